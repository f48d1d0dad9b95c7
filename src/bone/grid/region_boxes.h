// Where regions lie, as boxes.
#pragma once

#include <array>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Boxes that together are the voxels of the region grid whose region is `wanted`; runs of voxels along z are one box.
/// World frame, mm, in the order of the grid. Allocates.
std::vector<Box3> FindRegionBoxes(const Bone& bone, const std::array<bool, 256>& wanted);

}  // namespace kerf
