# %% [markdown]
# # Voxel or slab, on a patient
#
# The paper that kerf implements models a cut as a thin slab that slides against friction. It is about fifty times
# cheaper than removing voxels. How much of the force does it keep? Here both cut through the body of a patient's lower
# jaw: the Visible Human Female's, if its CT is beside the checkout (docs/import.md), otherwise the generic mandible.

# %%
import os
import pathlib

import matplotlib.pyplot as plt
import numpy as np

import kerf

folders = [pathlib.Path("scenes"), pathlib.Path(kerf.__file__).parents[4] / "share/kerf/scenes"]  # a checkout, an installation
scenes = next(folder for folder in folders if (folder / "slab_mandible.toml").is_file())
ct = pathlib.Path(os.environ.get("KERF_SCANS", "../shared/data")) / "visible_human_female/dicom"
if ct.is_dir():
    scene = kerf.Scene.read(scenes / "visible_human_compare.toml")
    bone, report = kerf.Bone.from_file(ct, voxel_mm=0.125)
    print("Visible Human Female:", bone)
    for warning in report["warnings"]:
        print("warning:", warning)
else:
    scene = kerf.Scene.read(scenes / "slab_mandible.toml")
    bone = kerf.Bone.mandible(voxel_mm=0.125)
    print("generic mandible:", bone)

# %% [markdown]
# The scene says where the saw goes. In voxel mode the saw removes bone. In slab mode the same scene samples the material
# in front of the blade once and then needs no voxels.

# %%
voxel = kerf.run(scene.with_value("simulation", "mode", "voxel"), bone)
unused_law = scene.with_value("force", "law", "two_component")  # the default: a law of its own would be warned of
slab = kerf.run(unused_law.with_value("simulation", "mode", "slab"), bone)
force = {name: run.ticks["force_z_N"] for name, run in {"voxels": voxel, "slab": slab}.items()}
for name, run in {"voxels": voxel, "slab": slab}.items():
    print(f"{name}: {len(run.ticks)} ticks, {1e6 * run.wall_s / len(run.ticks):.2f} us per tick, "
          f"largest upward force {force[name].max():.2f} N")

# %%
figure, axes = plt.subplots(figsize=(7, 4))
for name, run in {"voxels": voxel, "slab": slab}.items():
    axes.plot(run.ticks["z_mm"], force[name], label=name, linewidth=1)
axes.invert_xaxis()
axes.set_xlabel("height of the saw's centre, mm; it moves down, to the right")
axes.set_ylabel("force along z on the saw or the hand, N")
axes.legend()
figure.tight_layout()

# %% [markdown]
# The impulse, the integral of the force over the time, compares the two in one number.

# %%
impulse = {name: np.trapz(force[name], run.ticks["time_s"]) for name, run in {"voxels": voxel, "slab": slab}.items()}
print({name: f"{value:.2f} N s" for name, value in impulse.items()}, f"ratio slab / voxels {impulse['slab'] / impulse['voxels']:.3f}")
print(f"removed {voxel.removed_mm3:.0f} mm3 in", len(voxel.removed_by_region_mm3), "regions; pieces:",
      [f"{piece.volume_mm3() / 1000:.1f} cm3" for piece in voxel.bone.pieces(100)])
