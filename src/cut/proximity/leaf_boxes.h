// The bone as boxes: what the search for the nearest bone looks at.
#pragma once

#include <vector>

#include "bone/grid/field.h"
#include "kerf/geometry.h"

namespace kerf {

/// Boxes that hold all bone between them, world frame, mm. Where the surface passes, one for each leaf or, where leaves
/// are larger than 1.2 mm, for each eighth of one, drawn in to what bone there is; leaves of nothing but bone are
/// joined to large boxes. "Bone" is where phi, trilinear between voxel centres, is negative. Allocates.
std::vector<Box3> MakeLeafBoxes(const BoneField& field);

}  // namespace kerf
