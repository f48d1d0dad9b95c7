#include "bone/grid/region_boxes.h"

#include "bone/grid/grids.h"

namespace kerf {

std::vector<Box3> FindRegionBoxes(const Bone& bone, const std::array<bool, 256>& wanted) {
  const openvdb::Int32Grid& grid = *GridsOf(bone).region;
  const double h = GridsOf(bone).region_voxel_mm();
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
    const openvdb::Coord origin = leaf->origin();
    for (int column = 0; column < kLeafEdge * kLeafEdge; ++column) {
      for (int z = 0; z < kLeafEdge; ++z) {
        const auto at = [&](int k) { return leaf->getValue(static_cast<openvdb::Index>(column * kLeafEdge + k)); };
        if (!is_wanted(at(z))) continue;
        const int first = z;
        while (z + 1 < kLeafEdge && is_wanted(at(z + 1))) ++z;
        const openvdb::Coord low = origin.offsetBy(column / kLeafEdge, column % kLeafEdge, first);
        add(low, low.offsetBy(0, 0, z - first));
      }
    }
  }
  // Tiles: whole nodes of one region.
  auto tile = grid.tree().cbeginValueAll();
  tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (!is_wanted(*tile)) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    add(box.min(), box.max());
  }
  return boxes;
}

}  // namespace kerf
