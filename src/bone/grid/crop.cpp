#include "bone/grid/crop.h"

#include <openvdb/openvdb.h>

#include <cmath>

#include "bone/grid/grids.h"

namespace kerf {

Bone CropBone(const Bone& bone, const Box3& box_W) {
  Bone part = bone;
  if (box_W.empty() || bone.empty()) return part;
  const double leaf_mm = kLeafEdge * bone.voxel_mm();
  const auto first = [&](double mm) { return kLeafEdge * static_cast<int>(std::floor(mm / leaf_mm)); };
  const openvdb::Coord lower(first(box_W.lower.x), first(box_W.lower.y), first(box_W.lower.z));
  const openvdb::Coord upper(first(box_W.upper.x), first(box_W.upper.y), first(box_W.upper.z));
  openvdb::FloatTree& phi = GridsOf(part).phi->tree();
  phi.clip({lower, upper.offsetBy(kLeafEdge - 1)});
  return part;
}

}  // namespace kerf
