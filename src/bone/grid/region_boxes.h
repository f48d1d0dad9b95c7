// Regions as sets of boxes.
#pragma once

#include <array>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Returns boxes that together cover exactly the voxels of the region grid whose region is `wanted`; a run of voxels
/// along z is one box. World frame, mm, in the order of the grid. Allocates.
std::vector<Box3> FindRegionBoxes(const Bone& bone, const std::array<bool, 256>& wanted);

}  // namespace kerf
