// The bone as boxes, for nearest-bone queries.
#pragma once

#include <vector>

#include "bone/grid/field.h"
#include "kerf/geometry.h"

namespace kerf {

/// Returns boxes that together contain all bone, world frame, mm. Where the surface passes there is one box for each
/// leaf, or for each eighth of a leaf if leaves are larger than 1.2 mm, shrunk to the bone in it. Leaves of pure bone
/// are merged into large boxes. "Bone" is where phi, trilinear between voxel centres, is negative. Allocates.
std::vector<Box3> MakeLeafBoxes(const BoneField& field);

}  // namespace kerf
