#include "cut/removal/ledger.h"

#include <algorithm>
#include <bit>
#include <tuple>

#include "bone/grid/cell_fields.h"

namespace kerf {

/// The voxels whose values differ, among those that a leaf's CellFields holds.
class Ledger::ChangedVoxels {
 public:
  /// Adds those of the leaf, or of its neighbour (bx, by, bz), each -1 to 1.
  void Add(const Mask& mask, int bx, int by, int bz) {
    const auto begin = [](int b) { return b < 0 ? 7 : 0; };
    const auto end = [](int b) { return b > 0 ? 2 : 8; };
    for (int x = begin(bx); x < end(bx); ++x) {
      for (int y = begin(by); y < end(by); ++y) {
        const unsigned bits = static_cast<unsigned>(mask[static_cast<std::size_t>(x) * 8 + static_cast<std::size_t>(y)])
                                  << 9 >>
                              (8 - 8 * bz);
        Row(8 * bx + x, 8 * by + y) |= bits & 0x7ffu;
      }
    }
  }
  /// Returns whether the volume of any cell of the leaf depends on one of them.
  bool any_cell() const {
    for (int x = 0; x < 8; ++x) {
      for (int y = 0; y < 8; ++y) {
        if (CellsAround(x, y) != 0) return true;
      }
    }
    return false;
  }
  /// Returns, bit by bit along z, whether the volume of cell (x, y, z) depends on one of them.
  unsigned CellsAround(int x, int y) const {
    unsigned bits = 0;
    for (int i = x - 1; i <= x + 2; ++i) {
      for (int j = y - 1; j <= y + 2; ++j) bits |= Row(i, j);
    }
    return (bits | bits >> 1 | bits >> 2 | bits >> 3) & 0xffu;
  }

 private:
  static std::size_t At(int x, int y) {
    return static_cast<std::size_t>(x + 1) * CellFields::kEdge + static_cast<std::size_t>(y + 1);
  }
  unsigned& Row(int x, int y) { return rows_[At(x, y)]; }
  unsigned Row(int x, int y) const { return rows_[At(x, y)]; }

  std::array<unsigned, CellFields::kEdge * CellFields::kEdge> rows_{};  // bit z + 1: the voxel (x, y, z)
};

Ledger::Ledger(const BoneField& field)
    : field_(field),
      lowest_(field.lowest()),
      count_{field.highest().x - lowest_.x + 1, field.highest().y - lowest_.y + 1, field.highest().z - lowest_.z + 1},
      marks_(
          static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) * static_cast<std::size_t>(count_.z),
          0) {
  uncut_.fill(static_cast<float>(-field.band_mm()));
  air_.fill(static_cast<float>(field.band_mm()));
  // Every leaf with bone may be recorded once.
  std::size_t with_bone = 0;
  for (int x = 0; x < count_.x; ++x) {
    for (int y = 0; y < count_.y; ++y) {
      for (int z = 0; z < count_.z; ++z) {
        const LeafIndex leaf{lowest_.x + x, lowest_.y + y, lowest_.z + z};
        with_bone += field.kind(leaf) == BoneField::LeafKind::kOutside ? 0 : 1;
        if (FindCopy(leaf) < 0) continue;
        marks_[Place(leaf)] = kCounted;
        ++cut_leaves_;
      }
    }
  }
  entries_.reserve(with_bone);
  copies_.reserve(cut_leaves_);
}

std::size_t Ledger::Place(const LeafIndex& leaf) const {
  return (static_cast<std::size_t>(leaf.x - lowest_.x) * static_cast<std::size_t>(count_.y) +
          static_cast<std::size_t>(leaf.y - lowest_.y)) *
             static_cast<std::size_t>(count_.z) +
         static_cast<std::size_t>(leaf.z - lowest_.z);
}

int Ledger::FindCopy(const LeafIndex& leaf) const {
  const float* const cut = field_.ReadParts(leaf).cut;
  if (cut == field_.inside()) return kUncut;
  return field_.kind(leaf) == BoneField::LeafKind::kOutside && cut == field_.Read(leaf) ? kAir : 0;
}

void Ledger::Note(const LeafIndex& leaf) {
  std::uint8_t& marks = marks_[Place(leaf)];
  int copy = FindCopy(leaf);
  if (copy == 0) {
    copy = static_cast<int>(copies_.size());
    std::copy_n(field_.ReadParts(leaf).cut, BoneField::kLeafVoxels, copies_.emplace_back().begin());
  }
  if ((marks & kCounted) == 0) ++cut_leaves_;
  marks = kNoted | kCounted;
  entries_.push_back({leaf, copy});
}

Ledger::Mask Ledger::FindChanged(const LeafIndex& leaf, const float* old_values) const {
  const float* const values = field_.ReadParts(leaf).cut;
  Mask mask{};
  for (std::size_t row = 0; row < mask.size(); ++row) {
    unsigned bits = 0;
    for (std::size_t z = 0; z < 8; ++z) bits |= (values[8 * row + z] != old_values[8 * row + z] ? 1u : 0u) << z;
    mask[row] = static_cast<std::uint8_t>(bits);
  }
  return mask;
}

const std::array<double, 256>& Ledger::Account() {
  const auto before = [](const LeafIndex& a, const LeafIndex& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::sort(entries_.begin(), entries_.end(), [&](const Entry& a, const Entry& b) { return before(a.leaf, b.leaf); });
  const auto old_values = [&](const Entry& entry) {
    if (entry.copy == kUncut) return uncut_.data();
    return entry.copy == kAir ? air_.data() : copies_[static_cast<std::size_t>(entry.copy)].data();
  };
  std::vector<Mask> masks;
  masks.reserve(entries_.size());
  for (const Entry& entry : entries_) masks.push_back(FindChanged(entry.leaf, old_values(entry)));
  // A cell belongs to the leaf that contains its lowest corner. Its volume depends on a layer of voxels around it, so
  // the cells to recompute belong to the changed leaves and their neighbours.
  std::vector<LeafIndex> owners;
  for (const Entry& entry : entries_) {
    for (int i = 0; i < 27; ++i) {
      owners.push_back({entry.leaf.x + i / 9 - 1, entry.leaf.y + i / 3 % 3 - 1, entry.leaf.z + i % 3 - 1});
    }
  }
  std::sort(owners.begin(), owners.end(), before);
  owners.erase(std::unique(owners.begin(), owners.end()), owners.end());
  CellFields now(field_.voxel_mm(), field_.band_mm());
  for (const LeafIndex& owner : owners) {
    const auto at = [&](int x, int y, int z) { return LeafIndex{owner.x + x, owner.y + y, owner.z + z}; };
    ChangedVoxels changed;
    std::array<const float*, 27> old_cuts{};
    const auto index = [](int x, int y, int z) {
      return static_cast<std::size_t>(x + 1) * 9 + static_cast<std::size_t>(y + 1) * 3 +
             static_cast<std::size_t>(z + 1);
    };
    for (int i = 0; i < 27; ++i) {
      const int x = i / 9 - 1, y = i / 3 % 3 - 1, z = i % 3 - 1;
      const LeafIndex leaf = at(x, y, z);
      const auto found =
          std::lower_bound(entries_.begin(), entries_.end(), leaf,
                           [&](const Entry& entry, const LeafIndex& l) { return before(entry.leaf, l); });
      if (found == entries_.end() || !(found->leaf == leaf)) continue;
      old_cuts[index(x, y, z)] = old_values(*found);
      changed.Add(masks[static_cast<std::size_t>(found - entries_.begin())], x, y, z);
    }
    if (!changed.any_cell()) continue;
    now.Load([&](int x, int y, int z) { return field_.ReadParts(at(x, y, z)); });
    CellFields old = now;
    old.LoadCut([&](int x, int y, int z) { return old_cuts[index(x, y, z)]; });
    AddLoss(owner, changed, old, now);
  }
  for (const Entry& entry : entries_) marks_[Place(entry.leaf)] = kCounted;
  entries_.clear();
  copies_.clear();
  copies_.reserve(cut_leaves_);
  return removed_mm3_;
}

int Ledger::FindLostRegion(const LeafIndex& owner, const std::array<int, 3>& cell, const CellFields& old,
                           const CellFields& now) const {
  const double h = field_.voxel_mm();
  const auto region_at = [&](const Vec3& p_F) { return std::clamp(field_.RegionAt(p_F), 0, 255); };
  const int at_centre =
      region_at(h * (Vec3(8 * owner.x + cell[0], 8 * owner.y + cell[1], 8 * owner.z + cell[2]) + 0.5));
  if (!field_.is_metal(at_centre)) return at_centre;
  for (int corner = 0; corner < 8; ++corner) {
    const int x = cell[0] + (corner >> 2 & 1), y = cell[1] + (corner >> 1 & 1), z = cell[2] + (corner & 1);
    if (old.CutAt(x, y, z) == now.CutAt(x, y, z)) continue;
    // The same place as in MetalVoxels, bit for bit.
    const Vec3 lowest_F = h * (8.0 * Vec3(owner.x + x / 8, owner.y + y / 8, owner.z + z / 8));
    const int region = region_at(lowest_F + h * Vec3(x % 8, y % 8, z % 8));
    if (!field_.is_metal(region)) return region;
  }
  return at_centre;
}

void Ledger::AddLoss(const LeafIndex& owner, const ChangedVoxels& changed, const CellFields& old,
                     const CellFields& now) {
  const double h = field_.voxel_mm();
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      for (unsigned cells = changed.CellsAround(x, y); cells != 0; cells &= cells - 1) {
        const int z = std::countr_zero(cells);
        const double fraction = old.CalcFraction(x, y, z) - now.CalcFraction(x, y, z);
        if (fraction == 0) continue;
        const int region = FindLostRegion(owner, {x, y, z}, old, now);
        removed_mm3_[static_cast<std::size_t>(region)] += fraction * h * h * h;
      }
    }
  }
}

std::size_t Ledger::CalcMemoryBytes() const {
  return marks_.capacity() + entries_.capacity() * sizeof(Entry) + copies_.capacity() * sizeof(Values);
}

}  // namespace kerf
