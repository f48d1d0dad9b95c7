// Voxels of metal, such as implants and plates, which no bone saw removes.
#pragma once

#include <bitset>
#include <cstdint>
#include <vector>

#include "bone/grid/field.h"

namespace kerf {

class MetalVoxels {
 public:
  using Leaf = std::bitset<BoneField::kLeafVoxels>;

  /// Finds the metal of a bone by its regions. Allocates only if there is some, and then visits all of the bone.
  explicit MetalVoxels(const BoneField& field);

  /// Returns the metal voxels of a leaf; null if it has none. Tick-safe.
  const Leaf* Find(const LeafIndex& leaf) const {
    if (places_.empty()) return nullptr;
    const std::int32_t at = places_[field_->PlaceOf(leaf)];
    return at < 0 ? nullptr : &leaves_[static_cast<std::size_t>(at)];
  }
  std::size_t CalcMemoryBytes() const {
    return places_.capacity() * sizeof(std::int32_t) + leaves_.capacity() * sizeof(Leaf);
  }

 private:
  const BoneField* field_;
  std::vector<std::int32_t> places_;  // by place of the leaf: index in leaves_, -1: no metal; empty: no metal at all
  std::vector<Leaf> leaves_;
};

}  // namespace kerf
