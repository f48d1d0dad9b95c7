#include "bone/grid/dilate.h"

namespace kerf {

void Dilate(openvdb::MaskTree& voxels, int steps, openvdb::tools::NearestNeighbors neighbours,
            openvdb::tools::TilePolicy tiles) {
  openvdb::tools::dilateActiveValues(voxels, steps, neighbours, tiles);
}

}  // namespace kerf
