// A hash of all voxels that have changed, kept up to date as they change.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// The sum, over all leaves that were ever told to it, of a hash of where the leaf is and of the values that it was
/// told last. So it does not matter in which order leaves come, nor whether one that has not changed comes again: two
/// bones that began alike and have the same hash after the same changes are (nearly certainly) the same to the bit.
class ChangedHash {
 public:
  /// Room for so many leaves, 16 bytes each and as much again; those that come when it is full are passed over, the
  /// same each time.
  explicit ChangedHash(std::size_t leaves = std::size_t{1} << 18);

  /// Tick-safe; 0.1 us.
  void Take(const ChangedLeaf& leaf);
  std::uint64_t value() const { return sum_; }
  std::size_t leaves() const { return count_; }

 private:
  struct Slot {
    std::uint64_t key = 0;  // of the leaf; 0: free
    std::uint64_t hash = 0;
  };
  std::vector<Slot> slots_;
  std::size_t most_;
  std::size_t count_ = 0;
  std::uint64_t sum_ = 0;
};

}  // namespace kerf
