#include "bone/grid/fill_voids.h"

#include <openvdb/tools/LevelSetUtil.h>

#include <cmath>

namespace kerf {
namespace {

using openvdb::BoolTree;
using openvdb::Coord;
using FloatTree = openvdb::FloatTree;
using FloatLeaf = FloatTree::LeafNodeType;

constexpr float kSolid = -1;

/// Returns the voxels that the solid encloses but that are not solid.
BoolTree FindVoids(const FloatTree& field) {
  const BoolTree::Ptr enclosed = openvdb::tools::extractEnclosedRegion(field);  // including the solid
  BoolTree voids(false);
  for (auto leaf = enclosed->cbeginLeaf(); leaf; ++leaf) {
    const FloatLeaf* values = field.probeConstLeaf(leaf->origin());
    if (values == nullptr) continue;  // not a leaf of the field
    BoolTree::LeafNodeType* to = nullptr;
    for (auto it = leaf->cbeginValueOn(); it; ++it) {
      if (values->getValue(it.pos()) < 0) continue;
      if (to == nullptr) to = voids.touchLeaf(leaf->origin());
      to->setValueOn(it.pos(), true);
    }
  }
  auto tile = enclosed->cbeginValueOn();
  tile.setMaxDepth(BoolTree::ValueOnCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox box;
    tile.getBoundingBox(box);
    for (int x = box.min().x(); x <= box.max().x(); x += 8) {
      for (int y = box.min().y(); y <= box.max().y(); y += 8) {
        for (int z = box.min().z(); z <= box.max().z(); z += 8) {
          const Coord origin(x, y, z);
          if (field.probeConstLeaf(origin) == nullptr && field.getValue(origin) >= 0) {
            voids.addTile(1, origin, true, true);
          }
        }
      }
    }
  }
  return voids;
}

}  // namespace

FilledVoids FillVoids(FloatTree& field, double voxel_mm, std::vector<Coord>& filled_blocks) {
  const BoolTree voids = FindVoids(field);
  std::vector<openvdb::MaskTree::Ptr> each;
  if (!voids.empty()) {
    const openvdb::MaskTree mask(voids, false, true, openvdb::TopologyCopy());
    openvdb::tools::segmentActiveVoxels(mask, each);
  }
  for (auto it = voids.cbeginValueOn(); it; ++it) {
    if (it.isVoxelValue()) {
      field.setValueOn(it.getCoord(), kSolid);
    } else {
      field.addTile(1, it.getCoord(), kSolid, false);
      filled_blocks.push_back(it.getCoord());
    }
  }
  return {each.size(), static_cast<double>(voids.activeVoxelCount()) * std::pow(voxel_mm, 3)};
}

}  // namespace kerf
