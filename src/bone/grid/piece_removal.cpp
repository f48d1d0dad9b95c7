#include "bone/grid/piece_removal.h"

#include <fmt/format.h>
#include <openvdb/tools/Prune.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "bone/grid/parts_reader.h"
#include "bone/grid/removed.h"
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

/// The voxels of a piece among those of its bone.
class PieceVoxels {
 public:
  PieceVoxels(const Bone& bone, const PieceFinder& finder, int id) : phi_(GridsOf(bone).phi->getConstAccessor()) {
    finder.ForEachLeaf(id, [&](const Index3& leaf, const LeafMask& mask) {
      LeafMask& sum = masks_.try_emplace(leaf, LeafMask{}).first->second;
      for (std::size_t x = 0; x < 8; ++x) sum[x] |= mask[x];
    });
  }
  /// Returns the leaves of the piece and those around them, for the outer side of the band.
  std::set<Index3> ListLeaves() const {
    std::set<Index3> leaves;
    for (const auto& [leaf, mask] : masks_) {
      for (const Index3& near : FindCellLeaves(leaf)) leaves.insert(near);
    }
    return leaves;
  }
  float PhiAt(const Coord& p) const { return phi_.getValue(p); }
  bool IsPiece(const Coord& p) const {
    const auto found = masks_.find({p.x() >> 3, p.y() >> 3, p.z() >> 3});
    return found != masks_.end() &&
           (found->second[static_cast<std::size_t>(p.x() & 7)] >> (8 * (p.y() & 7) + (p.z() & 7)) & 1) != 0;
  }
  bool IsRest(const Coord& p) const { return PhiAt(p) < 0 && !IsPiece(p); }
  /// Whether the leaf or one around it contains remaining bone.
  bool HasRestAround(const Index3& leaf) {
    const std::array<Index3, 27> leaves = FindCellLeaves(leaf);
    return std::any_of(leaves.begin(), leaves.end(), [this](const Index3& near) { return HasRest(near); });
  }

 private:
  /// Determined on demand: only a few of the leaves around a piece do.
  bool HasRest(const Index3& leaf) {
    const auto [found, is_new] = has_rest_.try_emplace(leaf, false);
    for (int i = 0; is_new && i < 512 && !found->second; ++i) {
      found->second = IsRest(OriginOf(leaf).offsetBy(i / 64, i / 8 % 8, i % 8));
    }
    return found->second;
  }

  openvdb::FloatGrid::ConstAccessor phi_;
  std::map<Index3, LeafMask> masks_;
  std::map<Index3, bool> has_rest_;
};

/// What is near the voxels of a leaf.
class Surroundings {
 public:
  Surroundings(PieceVoxels& voxels, const Index3& leaf) : origin_(OriginOf(leaf)) {
    if (!voxels.HasRestAround(leaf)) return;
    Around taken{};
    for (int x = 0; x < kWide; ++x) {
      for (int y = 0; y < kWide; ++y) {
        for (int z = 0; z < kWide; ++z) {
          const Coord p = origin_.offsetBy(x - kReach, y - kReach, z - kReach);
          if (!(voxels.PhiAt(p) < 0)) continue;
          taken[At(x, y, z)] = voxels.IsPiece(p);
          rest_[At(x, y, z)] = !taken[At(x, y, z)];
        }
      }
    }
    beside_rest_ = Grown(rest_, 1);
    around_rest_ = Grown(rest_, 2);
    near_rest_ = Grown(rest_, kReach);
    beside_piece_ = Grown(taken, 1);
  }

  /// Returns the value of the cut at a voxel of the leaf without the piece.
  float CalcCutWithout(const PieceVoxels& voxels, const PartsReader& parts, const Coord& p, float band,
                       float voxel_mm) const {
    const float cut = parts.CutAt(p);
    const float phi = voxels.PhiAt(p);
    const std::size_t at = Place(p);
    if (phi < 0 && !voxels.IsPiece(p)) return cut;
    if (!around_rest_[at]) {
      // Nothing of the remaining bone depends on this voxel. Farther from it, the value may be the distance to the
      // removed piece.
      return near_rest_[at] && phi >= 0 ? std::max(cut, voxel_mm) : band;
    }
    if (!beside_piece_[at]) return cut;
    // In a kerf hardly wider than a voxel, volumes of the remaining bone depend on this voxel (see CellFields). Beside
    // its surface, slivers of the piece would remain.
    const float value = std::max(cut, Continue(parts, p, band));
    if (value >= 0 || (phi >= 0 && beside_rest_[at])) return value;
    return phi < 0 ? band : voxel_mm;
  }

 private:
  std::size_t Place(const Coord& p) const {
    const Coord from = p - origin_;
    return At(from.x() + kReach, from.y() + kReach, from.z() + kReach);
  }
  /// Returns the value of the cut as if there were only the remaining bone: continued along an axis from its last two
  /// voxels, one of which is at most two away. -band if there are none.
  float Continue(const PartsReader& parts, const Coord& p, float band) const {
    float value = -band;
    for (int way = 0; way < 6; ++way) {
      Coord step(0);
      step[way / 2] = way % 2 == 0 ? 1 : -1;
      const int away = rest_[Place(p + step)] ? 1 : 2;
      const Coord last = p + Coord(step.x() * away, step.y() * away, step.z() * away), before = last + step;
      if (!rest_[Place(last)] || !rest_[Place(before)]) continue;
      const float at_last = parts.CutAt(last);
      value = std::max(value, at_last + static_cast<float>(away) * (at_last - parts.CutAt(before)));
    }
    return std::min(value, band);
  }

  Coord origin_;
  Around rest_{};                                                        // the remaining bone
  Around beside_rest_{}, around_rest_{}, near_rest_{}, beside_piece_{};  // within 1, 2, kReach and 1 voxels
};

/// Returns the volume by region that a bone loses by the changes, mm3: of the same cells, and with the same bits, as
/// the loss that a simulation counts.
std::array<double, 256> CalcLoss(const Bone& bone, const std::vector<LeafChange>& changes) {
  const double h = bone.voxel_mm();
  const PartsReader reader(GridsOf(bone));
  const auto region = GridsOf(bone).region->getConstAccessor();
  std::map<Index3, const LeafChange*> changed;
  std::set<Index3> owners;
  for (const LeafChange& change : changes) {
    changed[change.index] = &change;
    for (const Index3& owner : FindCellLeaves(change.index)) owners.insert(owner);
  }
  std::array<double, 256> loss{};
  CellFields was(h, bone.band_mm());
  for (const Index3& owner : owners) {
    const Coord origin = OriginOf(owner);
    reader.Load(origin, was);
    CellFields is = was;
    is.LoadCut([&](int x, int y, int z) {
      const auto found = changed.find({owner[0] + x, owner[1] + y, owner[2] + z});
      return found != changed.end() ? found->second->without.data()
                                    : reader.At(origin.offsetBy(8 * x, 8 * y, 8 * z)).cut;
    });
    if (was == is) continue;
    for (int i = 0; i < 512; ++i) {
      const int x = i / 64, y = i / 8 % 8, z = i % 8;
      if (!was.DiffersAround(is, x, y, z)) continue;
      const double fraction = was.CalcFraction(x, y, z) - is.CalcFraction(x, y, z);
      if (fraction == 0) continue;
      const Vec3 p_W = h * (Vec3(origin.x() + x, origin.y() + y, origin.z() + z) + 0.5);
      const int id = region.getValue(NearestVoxel(p_W, bone.region_voxel_mm()));
      if (id >= 0 && id < 256) loss[static_cast<std::size_t>(id)] += fraction * h * h * h;
    }
  }
  return loss;
}

}  // namespace

PieceRemoval MakePieceRemoval(const Bone& bone, const PieceFinder& finder, int id) {
  if (id == kAllDust && finder.found().dust_count == 0) throw Error("there is no dust");
  if (id != kAllDust && finder.found().At(id) == nullptr) throw Error(fmt::format("there is no piece {}", id));
  PieceVoxels voxels(bone, finder, id);
  const float band = GridsOf(bone).phi->background();
  const auto h = static_cast<float>(bone.voxel_mm());
  const PartsReader parts(GridsOf(bone));
  PieceRemoval removal;
  GridsOf(removal.piece) = GridsOf(bone);
  GridsOf(removal.piece).phi = openvdb::gridPtrCast<openvdb::FloatGrid>(GridsOf(bone).phi->copyGridWithNewTree());
  Index3 lowest{1 << 30, 1 << 30, 1 << 30}, highest{-(1 << 30), -(1 << 30), -(1 << 30)};
  for (const Index3& index : voxels.ListLeaves()) {
    const Surroundings around(voxels, index);
    LeafChange change;
    change.index = index;
    GetCut(bone, index, change.with);
    // A leaf without bone may keep a cut below the air of its whole bone, and may lie outside of the box of a field.
    const bool is_emptied =
        GridsOf(bone).phi->tree().probeConstLeaf(OriginOf(index)) == nullptr && voxels.PhiAt(OriginOf(index)) >= band;
    std::array<float, 512> alone;
    for (int i = 0; i < 512; ++i) {
      const Coord p = OriginOf(index).offsetBy(i / 64, i / 8 % 8, i % 8);
      const auto k = static_cast<std::size_t>(i);
      alone[k] = voxels.IsRest(p) ? band : voxels.PhiAt(p);
      change.without[k] = is_emptied ? change.with[k] : around.CalcCutWithout(voxels, parts, p, band, h);
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
  CopyParts(GridsOf(bone), GridsOf(removal.piece));
  openvdb::tools::pruneLevelSet(GridsOf(removal.piece).phi->tree(), band, -band);
  removal.mm3 = CalcLoss(bone, removal.leaves);
  return removal;
}

}  // namespace kerf
