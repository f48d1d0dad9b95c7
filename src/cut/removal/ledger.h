// What the bone has lost, exactly and by region, worked out when it is asked for.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bone/grid/field.h"

namespace kerf {

class CellBlock;

/// Remembers a leaf's old values when it is first changed; later the volume of all cells with a changed corner is taken
/// before and after. A leaf of pure bone needs no copy, and each leaf is remembered once, so that memory does not grow
/// with time: it is bounded by the leaves of the bone's first surface.
class Ledger {
 public:
  /// `copies`: of old values, 2 kB each. Allocates.
  Ledger(const BoneField& field, int copies);

  bool IsNoted(const LeafIndex& leaf) const { return noted_[Place(leaf)] != 0; }
  /// Whether another leaf can be noted. Tick-safe.
  bool HasRoom() const { return room() > 0; }
  /// How many more with old values.
  std::size_t room() const { return copies_.size() - copies_used_; }
  /// To be called once, before a leaf changes for the first time; `old_values`: null for pure bone. Tick-safe.
  void Note(const LeafIndex& leaf, const float* old_values);

  /// Adds what was lost since the last call and forgets the old values. Not tick-safe.
  const std::array<double, 256>& Account();
  std::size_t CalcMemoryBytes() const;

 private:
  using Values = std::array<float, BoneField::kLeafVoxels>;
  struct Entry {
    LeafIndex leaf;
    int copy;  // -1: pure bone
  };

  std::size_t Place(const LeafIndex& leaf) const;
  void AddLoss(const LeafIndex& owner, const CellBlock& old, const CellBlock& now);

  const BoneField& field_;
  LeafIndex lowest_;
  LeafIndex count_;
  std::vector<std::uint8_t> noted_;  // of the field's box
  std::vector<Entry> entries_;
  std::vector<Values> copies_;
  std::size_t copies_used_ = 0;
  Values pure_bone_;
  std::array<double, 256> removed_mm3_{};
};

}  // namespace kerf
