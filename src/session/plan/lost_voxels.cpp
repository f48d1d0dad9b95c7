#include "session/plan/lost_voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bone/grid/cell_block.h"
#include "bone/grid/cell_volume.h"
#include "bone/grid/grids.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kLeaf = 8;
constexpr double kLeastRise = 0.25;  // of a voxel

/// Lowest voxels of the leaves where the two may differ: those of either grid, and what tiles hold.
std::set<openvdb::Coord> FindLeaves(const openvdb::FloatGrid& before, const openvdb::FloatGrid& after) {
  std::set<openvdb::Coord> origins;
  for (const openvdb::FloatGrid* grid : {&before, &after}) {
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) origins.insert(leaf->origin());
  }
  // Bone of tiles that is gone altogether.
  for (auto tile = before.tree().cbeginValueAll(); tile; ++tile) {
    if (tile.isVoxelValue() || *tile >= 0) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    openvdb::Coord at;
    for (at.x() = box.min().x(); at.x() <= box.max().x(); at.x() += kLeaf) {
      for (at.y() = box.min().y(); at.y() <= box.max().y(); at.y() += kLeaf) {
        for (at.z() = box.min().z(); at.z() <= box.max().z(); at.z() += kLeaf) {
          if (after.tree().getValue(at) >= 0) origins.insert(at);
        }
      }
    }
  }
  return origins;
}

}  // namespace

Loss FindLoss(const Bone& before, const Bone& after, const std::optional<Box3>& within,
              const std::function<bool(const Vec3& p_W)>& keep) {
  const double h = before.voxel_mm();
  if (std::abs(after.voxel_mm() - h) > 1e-9 * h) {
    throw Error(fmt::format("the bone before has voxels of {} mm and the one after of {} mm; they must be one bone", h,
                            after.voxel_mm()));
  }
  const openvdb::FloatGrid& old_grid = *before.grids().phi;
  const openvdb::FloatGrid& new_grid = *after.grids().phi;
  auto old_values = old_grid.getConstAccessor();
  auto new_values = new_grid.getConstAccessor();
  const auto wanted = [&](const Vec3& p) {
    if (within &&
        !(glm::all(glm::greaterThanEqual(p, within->lower)) && glm::all(glm::lessThanEqual(p, within->upper)))) {
      return false;
    }
    return !keep || keep(p);
  };

  Loss loss;
  CellBlock a;
  CellBlock b;
  for (const openvdb::Coord& origin : FindLeaves(old_grid, new_grid)) {
    const Vec3 corner = h * Vec3(origin.x(), origin.y(), origin.z());
    if (within) {
      const Vec3 far = corner + Vec3(9 * h);
      if (glm::any(glm::lessThan(far, within->lower)) || glm::any(glm::greaterThan(corner, within->upper))) continue;
    }
    a.Load(old_values, origin);
    b.Load(new_values, origin);
    if (std::equal(a.data(), a.data() + CellBlock::kCount, b.data())) continue;
    for (int x = 0; x < kLeaf; ++x) {
      for (int y = 0; y < kLeaf; ++y) {
        for (int z = 0; z < kLeaf; ++z) {
          const Vec3 p = corner + h * Vec3(x, y, z);
          const double rise = static_cast<double>(b.at(x, y, z) - a.at(x, y, z)) / h;
          if (rise > kLeastRise && a.at(x, y, z) < 0 && wanted(p)) loss.voxels.push_back({p, std::min(rise, 1.0)});
          const double share = CalcCellShare(a.Corners(x, y, z)) - CalcCellShare(b.Corners(x, y, z));
          const Vec3 middle = p + Vec3(0.5 * h);
          if (share != 0 && wanted(middle)) loss.cells.push_back({middle, share * h * h * h});
        }
      }
    }
  }
  return loss;
}

}  // namespace kerf
