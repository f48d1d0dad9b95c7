// Filling of the voids that a solid encloses. Internal to bone, because it exposes OpenVDB types.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "bone/grid/build.h"

namespace kerf {

/// Fills the voids of a field (with -1): voxels with a value of at least 0 from which no path across faces of such
/// voxels leads out. All voxels of the field's leaves must be active. Blocks without a leaf are inside if negative. The
/// voxels of a leaf next to such a block must have the block's sign; otherwise the flood would leave the leaves. Adds
/// to `filled_blocks` the leaf-sized blocks without a leaf that are filled. The surface that can be reached from
/// outside stays bit-identical.
FilledVoids FillVoids(openvdb::FloatTree& field, double voxel_mm, std::vector<openvdb::Coord>& filled_blocks);

}  // namespace kerf
