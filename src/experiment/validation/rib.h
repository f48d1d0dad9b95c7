// The bone of the measurements, as a rib that a tool cuts into.
#pragma once

#include "kerf/bone.h"

namespace kerf {

/// Bone on either side of a cut across a rib.
inline constexpr double kRibMargin_mm = 0.4;
/// y of the middle of a rib. The cut is at no special position in the grid.
inline constexpr double kRibPlane_mm = 0.037;

/// Makes a rib: `length_mm` along x, `width_mm` of a cut and the margins along y, its edge at z = 0, `depth_mm` deep.
Bone MakeRib(double length_mm, double width_mm, double voxel_mm, double depth_mm);
/// Returns the voxels in which a cut of this width is made, mm.
double CalcRibVoxel(double width_mm);

}  // namespace kerf
