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
  const openvdb::CoordBBox box(lower, upper.offsetBy(kLeafEdge - 1));
  const BoneGrids& from = GridsOf(bone);
  BoneGrids& grids = GridsOf(part);
  const auto add_leaves = [&](const openvdb::FloatTree& source, openvdb::FloatTree& target) {
    for (auto leaf = source.cbeginLeaf(); leaf; ++leaf) {
      if (!box.isInside(leaf->origin()) || target.probeConstLeaf(leaf->origin()) != nullptr) continue;
      target.addLeaf(new openvdb::FloatTree::LeafNodeType(*leaf));
    }
  };
  grids.phi->tree().clip(box);
  add_leaves(from.phi->constTree(), grids.phi->tree());  // clip() has replaced those of one value by tiles
  if (!from.cut) return part;
  AddPartGrids(grids);
  add_leaves(from.whole->constTree(), grids.whole->tree());
  add_leaves(from.cut->constTree(), grids.cut->tree());
  auto tile = from.cut->cbeginValueOn();
  tile.setMaxDepth(openvdb::FloatTree::ValueOnCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (box.isInside(tile.getCoord())) grids.cut->tree().addTile(1, tile.getCoord(), *tile, true);
  }
  return part;
}

}  // namespace kerf
