// Growing a set of voxels.
#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tools/Morphology.h>

namespace kerf {

/// openvdb::tools::dilateActiveValues, compiled once: it takes longer to compile than any file that calls it.
void Dilate(openvdb::MaskTree& voxels, int steps, openvdb::tools::NearestNeighbors neighbours,
            openvdb::tools::TilePolicy tiles = openvdb::tools::PRESERVE_TILES);

}  // namespace kerf
