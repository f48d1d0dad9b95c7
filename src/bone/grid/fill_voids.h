// Voids that a solid encloses. OpenVDB's types: for bone alone.
#pragma once

#include <openvdb/openvdb.h>

#include <vector>

#include "bone/grid/build.h"

namespace kerf {

/// Makes the voids of a field solid (-1): voxels with a value of 0 and more from which no way over faces of such voxels
/// leads out. All voxels of its leaves must be active; blocks that are no leaves are inside where negative, and the
/// voxels of leaves beside such a block must have its sign (else the flood would leave the leaves). `filled_blocks`
/// gets the leaf-sized blocks that had no leaf and are solid now. The surface that can be reached from outside stays as
/// it is, bit by bit.
FilledVoids FillVoids(openvdb::FloatTree& field, double voxel_mm, std::vector<openvdb::Coord>& filled_blocks);

}  // namespace kerf
