#include "bone/region_boxes.h"

#include "bone/grids.h"

namespace kerf {

std::vector<Box3> FindRegionBoxes(const Bone& bone, const std::array<bool, 256>& wanted) {
  const openvdb::Int32Grid& grid = *bone.grids().region;
  const double h = bone.grids().region_voxel_mm();
  const auto is_wanted = [&](int region) {
    return region > 0 && region < 256 && wanted[static_cast<std::size_t>(region)];
  };
  std::vector<Box3> boxes;
  const auto add = [&](const openvdb::Coord& low, const openvdb::Coord& high) {
    const Vec3 a(low.x(), low.y(), low.z());
    const Vec3 b(high.x(), high.y(), high.z());
    boxes.push_back({(a - 0.5) * h, (b + 0.5) * h});
  };
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    constexpr int kEdge = 8;
    static_assert(openvdb::Int32Tree::LeafNodeType::DIM == kEdge);
    const openvdb::Coord origin = leaf->origin();
    for (int column = 0; column < kEdge * kEdge; ++column) {
      for (int z = 0; z < kEdge; ++z) {
        const auto at = [&](int k) { return leaf->getValue(static_cast<openvdb::Index>(column * kEdge + k)); };
        if (!is_wanted(at(z))) continue;
        const int first = z;
        while (z + 1 < kEdge && is_wanted(at(z + 1))) ++z;
        const openvdb::Coord low = origin.offsetBy(column / kEdge, column % kEdge, first);
        add(low, low.offsetBy(0, 0, z - first));
      }
    }
  }
  // Whole nodes of one region.
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (!is_wanted(*tile)) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    add(box.min(), box.max());
  }
  return boxes;
}

std::vector<Box3> FindRegionShell(const Bone& bone, const std::array<bool, 256>& wanted) {
  const openvdb::Int32Grid& grid = *bone.grids().region;
  const double h = bone.grids().region_voxel_mm();
  const auto accessor = grid.getConstAccessor();
  const auto is_wanted = [&](const openvdb::Coord& at) {
    const int region = accessor.getValue(at);
    return region > 0 && region < 256 && wanted[static_cast<std::size_t>(region)];
  };
  std::vector<Box3> boxes;
  for (const Box3& inside : FindRegionBoxes(bone, wanted)) {
    // One voxel further on all sides; what of it is no part of the regions.
    const openvdb::Coord low = NearestVoxel(inside.lower + Vec3(0.5 * h), h);
    const openvdb::Coord high = NearestVoxel(inside.upper - Vec3(0.5 * h), h);
    openvdb::CoordBBox around(low, high);
    around.expand(1);
    for (openvdb::CoordBBox::Iterator<true> it(around); it; ++it) {
      const openvdb::Coord at = *it;
      int out = 0;
      for (int axis = 0; axis < 3; ++axis) out += at[axis] < low[axis] || at[axis] > high[axis];
      if (out != 1 || is_wanted(at)) continue;
      const Vec3 centre(at.x(), at.y(), at.z());
      boxes.push_back({(centre - 0.5) * h, (centre + 0.5) * h});
    }
  }
  return boxes;
}

}  // namespace kerf
