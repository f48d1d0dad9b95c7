// Filling of the voids that a solid encloses. Internal to bone, because it exposes OpenVDB types.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "bone/grid/build.h"

namespace kerf {

/// Fills the voids of a field with the value -1. A void consists of voxels with a value of at least 0 from which no
/// path through faces shared by such voxels leads out of the solid. A block without a leaf is inside if its value is
/// negative, and no such block may lie beyond the leaves. Adds to `filled_blocks` the leaf-sized blocks without a leaf
/// that are filled. The surface that can be reached from outside stays bit-identical.
FilledVoids FillVoids(openvdb::FloatTree& field, double voxel_mm, std::vector<openvdb::Coord>& filled_blocks);

}  // namespace kerf
