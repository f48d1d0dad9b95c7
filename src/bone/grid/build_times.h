// Estimated time of the construction of a bone, for an even progress.
#pragma once

namespace kerf {

/// Time that the parts of MakeBone() take for a solid that is no distance, s of processor time on one core: measured
/// with the mandible of a CT, with voxels of 0.1 and 0.2 mm. Only their ratios matter, for an even progress.
struct BuildTimes {
  double values_s = 0;     // evaluation of the field
  double voids_s = 0;      // filling of voids, and finding the voxels near the surface
  double distances_s = 0;  // fast sweeping
  double regions_s = 0;
  double total_s() const { return values_s + voids_s + distances_s + regions_s; }
};
/// `by_leaves`: the solid has values for whole leaves (SolidField::leaf_values).
BuildTimes EstimateBuildTimes(double voxel_mm, double region_voxel_mm, bool by_leaves);

}  // namespace kerf
