#include "session/plan/lost_voxels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "bone/grid/parts_reader.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr int kLeaf = 8;
constexpr double kMinRise = 0.25;  // in voxels

/// Returns the origins of the leaves where the two grids may differ: the leaves of either grid, and those in tiles of
/// bone from which bone was removed.
std::set<openvdb::Coord> FindLeaves(const openvdb::FloatGrid& before, const openvdb::FloatGrid& after) {
  std::set<openvdb::Coord> origins;
  for (const openvdb::FloatGrid* grid : {&before, &after}) {
    for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) origins.insert(leaf->origin());
  }
  // Tiles are bone throughout. Add the leaves where such bone has been removed.
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
    throw Error(
        fmt::format("the bone before the cut has voxels of {} mm, the bone after it {} mm; both must be the same bone",
                    h, after.voxel_mm()));
  }
  const PartsReader of_before(GridsOf(before));
  const PartsReader of_after(GridsOf(after));
  const auto wanted = [&](const Vec3& p) {
    if (within &&
        !(glm::all(glm::greaterThanEqual(p, within->lower)) && glm::all(glm::lessThanEqual(p, within->upper)))) {
      return false;
    }
    return !keep || keep(p);
  };

  Loss loss;
  CellFields a(h, before.band_mm());
  CellFields b(h, after.band_mm());
  for (const openvdb::Coord& origin : FindLeaves(*GridsOf(before).phi, *GridsOf(after).phi)) {
    const Vec3 corner = h * Vec3(origin.x(), origin.y(), origin.z());
    if (within) {
      const Vec3 far = corner + Vec3(9 * h);
      if (glm::any(glm::lessThan(far, within->lower)) || glm::any(glm::greaterThan(corner, within->upper))) continue;
    }
    of_before.Load(origin, a);
    of_after.Load(origin, b);
    if (a == b) continue;
    for (int x = 0; x < kLeaf; ++x) {
      for (int y = 0; y < kLeaf; ++y) {
        for (int z = 0; z < kLeaf; ++z) {
          const Vec3 p = corner + h * Vec3(x, y, z);
          const float was = a.PhiAt(x, y, z);
          const double rise = static_cast<double>(b.PhiAt(x, y, z) - was) / h;
          if (rise > kMinRise && was < 0 && wanted(p)) loss.voxels.push_back({p, std::min(rise, 1.0)});
          const double fraction = a.CalcFraction(x, y, z) - b.CalcFraction(x, y, z);
          const Vec3 middle = p + Vec3(0.5 * h);
          if (fraction != 0 && wanted(middle)) loss.cells.push_back({middle, fraction * h * h * h});
        }
      }
    }
  }
  return loss;
}

}  // namespace kerf
