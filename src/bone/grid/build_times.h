// Estimated time of the construction of a bone, for an even progress.
#pragma once

namespace kerf {

/// Time that the parts of MakeBone() take for a solid that is no distance, s on one core of 2.5 GHz: measured with the
/// mandible of a CT, with voxels of 0.1 and 0.2 mm. Only their ratios matter, for an even progress.
struct BuildTimes {
  double values_s = 0;     // evaluation of the field
  double voids_s = 0;      // filling of voids
  double distances_s = 0;  // fast sweeping
  double regions_s = 0;
  double total_s() const { return values_s + voids_s + distances_s + regions_s; }
};
BuildTimes EstimateBuildTimes(double voxel_mm, double region_voxel_mm);

}  // namespace kerf
