// Incremental hash of all changed voxels.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Sum, over all leaves ever passed to Take(), of a hash of the leaf's index and of its latest values. The sum does not
/// depend on the order of the leaves, and passing an unchanged leaf again has no effect. If two bones were equal at
/// first and have the same hash after the same changes, they are (almost certainly) bit-identical.
class ChangedHash {
 public:
  /// Reserves room for `leaves` leaves: at least two slots of 16 bytes for each. Once the table is full, new leaves are
  /// ignored; they are the same ones in each run.
  explicit ChangedHash(std::size_t leaves = std::size_t{1} << 18);

  /// Adds or updates a leaf. Tick-safe; takes 0.1 us.
  void Take(const ChangedLeaf& leaf);
  std::uint64_t value() const { return sum_; }
  std::size_t leaves() const { return count_; }

 private:
  struct Slot {
    std::uint64_t key = 0;  // of the leaf; 0: free slot
    std::uint64_t hash = 0;
  };
  std::vector<Slot> slots_;
  std::size_t max_leaves_;
  std::size_t count_ = 0;
  std::uint64_t sum_ = 0;
};

}  // namespace kerf
