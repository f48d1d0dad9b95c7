// Exact loss of bone by region, computed on request.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "bone/grid/field.h"

namespace kerf {

class CellFields;

/// Record of the old values of the cut (see BoneField) in each leaf at its first change. On request, the volume of all
/// cells with a changed corner is computed before and after. A leaf that was not cut before needs no copy, and each
/// leaf is recorded once.
class Ledger {
 public:
  /// `copies`: room for copies of old values, 2 kB each. Allocates.
  Ledger(const BoneField& field, int copies);

  bool IsNoted(const LeafIndex& leaf) const { return noted_[Place(leaf)] != 0; }
  /// Returns true if another leaf with old values can be recorded. Tick-safe.
  bool HasRoom() const { return room() > 0; }
  /// Number of leaves with old values that can still be recorded.
  std::size_t room() const { return copy_count_ - copies_used_; }
  /// Records a leaf that changes for the first time since the last Account(); must be called only once for each leaf.
  /// `old_values`: its values of the cut before the change; null if it was not cut. Tick-safe.
  void Note(const LeafIndex& leaf, const float* old_values);

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
    int copy;  // index in copies_; -1: not cut
  };

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
  std::vector<std::uint8_t> noted_;  // for each leaf of the field's box
  std::vector<Entry> entries_;
  std::size_t copy_count_;
  std::unique_ptr<Values[]> copies_;  // not initialised: most are never written, and then take no memory
  std::size_t copies_used_ = 0;
  Values uncut_;
  std::array<double, 256> removed_mm3_{};
};

}  // namespace kerf
