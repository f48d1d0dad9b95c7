#include "bone/grid/piece_removal.h"

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "bone/grid/grids.h"
#include "bone/grid/set_leaf.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using openvdb::Coord;
using Index3 = std::array<int, 3>;

constexpr int kReach = 3;  // voxels: the width of the band
constexpr int kWide = 8 + 2 * kReach;

/// One flag for each voxel of a leaf and its surroundings.
using Around = std::array<bool, kWide * kWide * kWide>;

std::size_t At(int x, int y, int z) {
  const int at = (x * kWide + y) * kWide + z;
  return static_cast<std::size_t>(at);
}

/// Returns a copy of the flags in which those within `by` voxels of a set flag, along each axis, are set too.
Around Grown(Around flags, int by) {
  for (int axis = 0; axis < 3; ++axis) {
    const int stride = axis == 0 ? kWide * kWide : axis == 1 ? kWide : 1;
    Around grown = flags;
    for (int i = 0; i < kWide * kWide * kWide; ++i) {
      if (!flags[static_cast<std::size_t>(i)]) continue;
      const int at = i / stride % kWide;
      for (int d = -std::min(by, at); d <= std::min(by, kWide - 1 - at); ++d) {
        const int other = i + d * stride;
        grown[static_cast<std::size_t>(other)] = true;
      }
    }
    flags = grown;
  }
  return flags;
}

bool IsIn(const LeafMask& mask, int x, int y, int z) {
  return (mask[static_cast<std::size_t>(x)] >> (8 * y + z) & 1) != 0;
}

}  // namespace

PieceRemoval MakePieceRemoval(const Bone& bone, const PieceFinder& finder, int id) {
  if (id == kAllDust && finder.found().dust_count == 0) throw Error("there is no dust");
  if (id != kAllDust && finder.found().At(id) == nullptr) throw Error(fmt::format("there is no piece {}", id));
  std::map<Index3, LeafMask> own;
  finder.ForEachLeaf(id, [&](const Index3& index, const LeafMask& mask) {
    LeafMask& sum = own.try_emplace(index, LeafMask{}).first->second;
    for (std::size_t x = 0; x < 8; ++x) sum[x] |= mask[x];
  });
  std::map<Index3, bool> touched;  // includes adjacent leaves, for the outer side of the band
  for (const auto& [index, mask] : own) {
    for (int k = 0; k < 27; ++k) touched[{index[0] + k / 9 - 1, index[1] + k / 3 % 3 - 1, index[2] + k % 3 - 1}] = true;
  }
  const auto accessor = GridsOf(bone).phi->getConstAccessor();
  const float band = GridsOf(bone).phi->background();
  const auto h = static_cast<float>(bone.voxel_mm());
  const LeafMask none{};
  const auto own_of = [&](const Index3& index) -> const LeafMask& {
    const auto found = own.find(index);
    return found == own.end() ? none : found->second;
  };
  // Whether a leaf contains remaining bone, determined on demand: only a few of the leaves around a piece do.
  std::map<Index3, bool> rest_in;
  const auto has_rest = [&](const Index3& index) {
    const auto [found, is_new] = rest_in.try_emplace(index, false);
    if (!is_new) return found->second;
    const Coord origin(8 * index[0], 8 * index[1], 8 * index[2]);
    const LeafMask& mask = own_of(index);
    for (int i = 0; i < 512 && !found->second; ++i) {
      const int x = i / 64, y = i / 8 % 8, z = i % 8;
      found->second = accessor.getValue(origin.offsetBy(x, y, z)) < 0 && !IsIn(mask, x, y, z);
    }
    return found->second;
  };

  PieceRemoval removal;
  GridsOf(removal.piece) = GridsOf(bone);
  GridsOf(removal.piece).phi = MakePhiGrid(bone.voxel_mm());
  Index3 lowest{1 << 30, 1 << 30, 1 << 30}, highest{-(1 << 30), -(1 << 30), -(1 << 30)};
  for (const auto& [index, yes] : touched) {
    const Coord origin(8 * index[0], 8 * index[1], 8 * index[2]);
    Around rest{};
    bool any_rest = false;
    for (int k = 0; k < 27; ++k) {
      any_rest = has_rest({index[0] + k / 9 - 1, index[1] + k / 3 % 3 - 1, index[2] + k % 3 - 1}) || any_rest;
    }
    for (int x = 0; any_rest && x < kWide; ++x) {
      for (int y = 0; y < kWide; ++y) {
        for (int z = 0; z < kWide; ++z) {
          const Coord p = origin.offsetBy(x - kReach, y - kReach, z - kReach);
          if (!(accessor.getValue(p) < 0)) continue;
          const LeafMask& mask = own_of({p.x() >> 3, p.y() >> 3, p.z() >> 3});
          rest[At(x, y, z)] = !IsIn(mask, p.x() & 7, p.y() & 7, p.z() & 7);
        }
      }
    }
    Around beside{}, near{};
    if (any_rest) {
      beside = Grown(rest, 1);
      near = Grown(rest, kReach);
    }
    LeafChange change;
    change.index = index;
    const LeafMask& mask = own_of(index);
    std::array<float, 512> alone;
    for (int i = 0; i < 512; ++i) {
      const int x = i / 64, y = i / 8 % 8, z = i % 8;
      const Coord p = origin.offsetBy(x, y, z);
      const float phi = accessor.getValue(p);
      const auto k = static_cast<std::size_t>(i);
      const std::size_t at = At(x + kReach, y + kReach, z + kReach);
      change.with[k] = change.without[k] = alone[k] = phi;
      if (phi < 0) {
        (IsIn(mask, x, y, z) ? change.without : alone)[k] = band;
      } else if (!beside[at]) {
        // No cell that contains surface of the remaining bone has this voxel as a corner. Farther from it, the value
        // may be the distance to the removed piece.
        change.without[k] = near[at] ? std::max(phi, h) : band;
      }
    }
    SetLeaf(removal.piece, index, alone);
    if (change.with == change.without) continue;
    removal.leaves.push_back(change);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], index[axis]);
      highest[axis] = std::max(highest[axis], index[axis]);
    }
  }
  const double leaf_mm = 8 * bone.voxel_mm();
  removal.bounds_W = {leaf_mm * Vec3(lowest[0], lowest[1], lowest[2]),
                      leaf_mm * (Vec3(highest[0], highest[1], highest[2]) + 1.0)};
  openvdb::tools::pruneLevelSet(GridsOf(removal.piece).phi->tree(), band, -band);
  for (const auto& [region, mm3] : removal.piece.CalcRegionVolumes()) {
    if (region >= 0 && region < 256) removal.mm3[static_cast<std::size_t>(region)] += mm3;
  }
  return removal;
}

}  // namespace kerf
