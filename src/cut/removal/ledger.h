// Exact loss of bone by region, computed on request.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bone/grid/field.h"

namespace kerf {

class CellFields;

/// Record of the old values of the cut (see BoneField) in each leaf at its first change. On request, the volume of all
/// cells with a changed corner is computed before and after. A leaf that was not cut before needs no copy, and each
/// leaf is recorded once between two accounts.
class Ledger {
 public:
  /// Only this ledger's caller may change the field meanwhile. Allocates.
  explicit Ledger(const BoneField& field);

  bool IsNoted(const LeafIndex& leaf) const { return (marks_[Place(leaf)] & kNoted) != 0; }
  /// Records a leaf before it changes for the first time since the last Account(); must be called only once for each
  /// leaf. Tick-safe.
  void Note(const LeafIndex& leaf);

  /// Adds the loss since the last call to the sums by region, mm3, and discards the old values. Returns the sums. Not
  /// tick-safe.
  const std::array<double, 256>& Account();
  std::size_t CalcMemoryBytes() const;

 private:
  using Values = std::array<float, BoneField::kLeafVoxels>;
  using Mask = std::array<std::uint8_t, BoneField::kLeafVoxels / 8>;  // bit z of row 8x + y: a voxel of the leaf
  class ChangedVoxels;
  struct Entry {
    LeafIndex leaf;
    int copy;  // index in copies_; kUncut, kAir: all values are the same
  };

  static constexpr int kUncut = -1;
  static constexpr int kAir = -2;
  // Marks of a leaf.
  static constexpr std::uint8_t kNoted = 1;
  static constexpr std::uint8_t kCounted = 2;  // in cut_leaves_

  /// Returns kUncut, kAir, or 0 if a leaf's values of the cut must be copied before they change.
  int FindCopy(const LeafIndex& leaf) const;
  std::size_t Place(const LeafIndex& leaf) const;
  /// Returns where a leaf's values of the cut differ from the old ones.
  Mask FindChanged(const LeafIndex& leaf, const float* old_values) const;
  /// Returns the region of the bone that a changed cell has lost: the one at its centre or, because metal is not
  /// removed, beside metal that of a voxel that has changed. `cell`: its lowest corner, in voxels from the owner's.
  int FindLostRegion(const LeafIndex& owner, const std::array<int, 3>& cell, const CellFields& old,
                     const CellFields& now) const;
  void AddLoss(const LeafIndex& owner, const ChangedVoxels& changed, const CellFields& old, const CellFields& now);

  const BoneField& field_;
  LeafIndex lowest_;
  LeafIndex count_;
  std::vector<std::uint8_t> marks_;  // of each leaf of the field's box
  std::size_t cut_leaves_ = 0;       // leaves that have been cut
  std::vector<Entry> entries_;
  // Has room for all leaves that had been cut at the last Account(): only these need a copy. Unused room takes no
  // memory.
  std::vector<Values> copies_;
  Values uncut_;
  Values air_;
  std::array<double, 256> removed_mm3_{};
};

}  // namespace kerf
