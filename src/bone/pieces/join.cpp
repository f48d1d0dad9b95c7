#include "bone/pieces/join.h"

#include <openvdb/tools/Composite.h>

#include <cmath>

#include "bone/grid/grids.h"
#include "kerf/error.h"

namespace kerf {

Bone JoinBones(const Bone& bone, const std::vector<const Bone*>& pieces) {
  Bone joined = bone;
  for (const Bone* piece : pieces) {
    if (piece->empty()) continue;
    if (std::abs(piece->voxel_mm() - bone.voxel_mm()) > 1e-9 * bone.voxel_mm()) {
      throw Error("a piece has a different voxel size from the bone that it was cut from");
    }
    openvdb::FloatGrid::Ptr copy = GridsOf(*piece).phi->deepCopy();
    openvdb::tools::csgUnion(*GridsOf(joined).phi, *copy);
  }
  GridsOf(joined).whole = GridsOf(joined).cut = nullptr;
  FinishLevelSet(*GridsOf(joined).phi);
  return joined;
}

}  // namespace kerf
