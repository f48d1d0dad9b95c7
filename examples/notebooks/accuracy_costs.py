# %% [markdown]
# # What accuracy costs
#
# Smaller voxels give a more accurate force and take more time. This notebook makes the same cut with voxels from 0.4 mm
# to 0.05 mm and compares each force with the finest one. `kerf study` does this for many paths and settings
# (docs/accuracy.md).

# %%
import time

import matplotlib.pyplot as plt
import numpy as np

import kerf

start = kerf.pose((-20, 0, 8), (1, 0, 0), -90)
poses = kerf.line(start, (20, 0, 8), feed_mm_per_s=20)
saw = kerf.Disc(diameter_mm=22, thickness_mm=0.8, teeth=60)


def cut(voxel_mm):
    """Returns the force over the path, the time per tick, and the bone's memory."""
    bone = kerf.Bone.block(size_mm=(20, 8, 10), layers=[(2.5, 24), (7.5, 32)], voxel_mm=voxel_mm)
    us = np.inf
    for _ in range(5):  # the shortest time is the least disturbed one
        simulation = kerf.Simulation(bone, start, tool=saw)
        began = time.perf_counter()
        ticks = simulation.run(poses)
        us = min(us, 1e6 * (time.perf_counter() - began) / len(ticks))
    force = np.stack([ticks[f"force_{axis}_N"] for axis in "xyz"], axis=1)
    removed = sum(simulation.removed_by_region_mm3().values())
    return force, us, bone.memory_bytes() / 1e6, removed


voxels = [0.4, 0.28, 0.2, 0.14, 0.1, 0.07]
finest, _, _, _ = cut(0.05)
rows = []
for voxel_mm in voxels:
    force, us, megabytes, removed = cut(voxel_mm)
    error = np.linalg.norm(force - finest) / np.linalg.norm(finest)
    rows.append((voxel_mm, 100 * error, us, megabytes, 100 * (removed / 48 - 1)))
    print("voxel {:.2f} mm: error of the force {:.2f} %, {:.0f} us per tick, {:.1f} MB, error of the volume {:+.2f} %".format(*rows[-1]))

# %% [markdown]
# The error of the force is the root mean square of its difference from the finest cut, divided by that of the force. Note
# that the finest cut has an error too. The volume is compared with the slot's exact 48 mm³.

# %%
table = np.array(rows)
figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3.5))
left.loglog(table[:, 0], table[:, 1], "o-", label="measured")
left.loglog(table[:, 0], table[0, 1] * (table[:, 0] / table[0, 0]), "--", label="first order")
left.set_xticks(voxels, [f"{voxel_mm:g}" for voxel_mm in voxels])
left.set_yticks([0.3, 1, 3], ["0.3", "1", "3"])
left.minorticks_off()
left.set_xlabel("edge of a voxel, mm")
left.set_ylabel("error of the force, %")
left.legend()
right.plot(table[:, 2], table[:, 1], "o-")
for voxel_mm, error, us, _, _ in rows:
    right.annotate(f"{voxel_mm:g} mm", (us, error), textcoords="offset points", xytext=(5, 5), fontsize=8)
right.set_xlim(0, 1.25 * table[:, 2].max())
right.set_ylim(0)
right.set_xlabel("time per tick, us")
right.set_ylabel("error of the force, %")
figure.tight_layout()
