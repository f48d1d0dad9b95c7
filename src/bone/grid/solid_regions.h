// Regions of the bone that is made from a solid.
#pragma once

#include <functional>

#include "bone/grid/build.h"

namespace kerf {

/// Replaces the region grid by the regions of the solid's leaf_regions(). Those of a mirrored solid (has_mirror()) are
/// copied to the other half.
void SetSolidRegions(Bone& bone, const SolidField& solid, double region_voxel_mm,
                     const std::function<void(double)>& report);

}  // namespace kerf
