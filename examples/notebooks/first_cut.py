# %% [markdown]
# # First cut
#
# A saw cuts a slot into a block of bone, and the force on it is drawn. Lengths are in mm, forces in N, times in s.

# %%
import matplotlib.pyplot as plt
import numpy as np

import kerf

# %% [markdown]
# The block has 2.5 mm of cortical bone (region 24) on cancellous bone (region 32). Its top is the plane z = 0. A bone
# answers questions about points, given as rows of an array. Distances are known up to three voxels from the surface, here
# 0.6 mm; they are negative inside.

# %%
bone = kerf.Bone.block(size_mm=(20, 8, 10), layers=[(2.5, 24), (7.5, 32)], voxel_mm=0.2)
points = np.array([[0, 0, -0.3], [0, 0, -4.0]])
print(bone)
print("distance to the surface, mm:", np.round(bone.phi(points), 3))
print("Young's modulus, MPa:       ", bone.modulus(points))

# %% [markdown]
# The saw stands upright: turned by -90 degrees about x, its spindle points along y. It starts beside the block, with its
# lowest tooth 3 mm below the top, and moves 40 mm along x at 8 mm/s. `line()` gives a pose for each tick of 1 ms, and
# `run()` makes all ticks in one call. The result is a table with a row for each tick.

# %%
start = kerf.pose((-20, 0, 8), (1, 0, 0), -90)
saw = kerf.Disc(diameter_mm=22, thickness_mm=0.5, teeth=24)
simulation = kerf.Simulation(bone, start, tool=saw)
ticks = simulation.run(kerf.line(start, (20, 0, 8), feed_mm_per_s=8))
print(len(ticks), "ticks with the columns", ", ".join(ticks.dtype.names))

# %%
force = np.sqrt(sum(ticks[f"force_{axis}_N"] ** 2 for axis in "xyz"))
figure, (above, below) = plt.subplots(2, 1, sharex=True, figsize=(7, 5))
above.plot(ticks["x_mm"], force, label="magnitude")
above.plot(ticks["x_mm"], ticks["force_x_N"], label="along x")
above.plot(ticks["x_mm"], ticks["force_z_N"], label="along z")
above.set_ylabel("force on the saw, N")
above.legend()
below.plot(ticks["x_mm"], ticks["engaged_teeth"])
below.set_ylabel("engaged teeth")
below.set_xlabel("position of the saw's centre, mm")
figure.tight_layout()

# %% [markdown]
# The volume that is gone is the product of the slot's width, its depth and the block's length, and the regions say what
# it was.

# %%
cut = simulation.bone()
print(f"removed {bone.volume_mm3() - cut.volume_mm3():.2f} mm3; 0.5 x 3 x 20 mm are {0.5 * 3 * 20:.0f} mm3")
print("by region:", {region: round(mm3, 2) for region, mm3 in simulation.removed_by_region_mm3().items()})

# %% [markdown]
# The surface of the bone as a mesh, drawn with matplotlib. Any other program can draw it too: `mesh()` gives the points
# and the triangles as arrays.

# %%
points, triangles = cut.mesh(adaptivity=0.5)
figure = plt.figure(figsize=(6, 4))
axes = figure.add_subplot(projection="3d")
axes.plot_trisurf(*points.T, triangles=triangles, color="wheat", edgecolor="none")
axes.set_box_aspect(np.ptp(points, axis=0))
axes.set_xlabel("x, mm")
axes.set_ylabel("y, mm")
axes.view_init(30, -60)
figure.tight_layout()
