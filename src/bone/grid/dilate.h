// Dilation of a set of voxels.
#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tools/Morphology.h>

namespace kerf {

/// Wraps openvdb::tools::dilateActiveValues so that it is compiled only once: it takes longer to compile than any file
/// that calls it.
void Dilate(openvdb::MaskTree& voxels, int steps, openvdb::tools::NearestNeighbors neighbours,
            openvdb::tools::TilePolicy tiles = openvdb::tools::PRESERVE_TILES);

}  // namespace kerf
