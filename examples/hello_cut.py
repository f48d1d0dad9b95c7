"""Cuts a slot into a block of bone and prints the force: the scene hello_cut.toml, tick by tick."""

import numpy as np

import kerf

# 2.5 mm of cortical bone (region 24) on cancellous bone (region 32); the block's top is z = 0.
bone = kerf.Bone.block(size_mm=(20, 8, 10), layers=[(2.5, 24), (7.5, 32)], voxel_mm=0.2)
start = kerf.pose((-20, 0, 8), (1, 0, 0), -90)  # upright: the spindle points along y; 3 mm below the top
saw = kerf.Disc(diameter_mm=22, thickness_mm=0.5, teeth=24)
simulation = kerf.Simulation(bone, start, tool=saw)

peak_N = removed_mm3 = 0.0
for pose in kerf.line(start, (20, 0, 8), feed_mm_per_s=10):  # one pose for each tick of 1 ms
    tick = simulation.tick(pose, dt=0.001, rpm=7500)
    peak_N = max(peak_N, np.linalg.norm(tick.force_N))
    removed_mm3 += tick.removed_mm3

print(f"peak force {peak_N:.6g} N, removed {removed_mm3:.4f} mm3, bone {simulation.bone().hash()}")
