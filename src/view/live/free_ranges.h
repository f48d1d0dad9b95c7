// Division of a buffer into ranges. Pure: it manages numbers only.
#pragma once

#include <cstdint>
#include <map>
#include <optional>

namespace kerf {

/// Half-open ranges of the numbers below a size: which are free, and which were taken.
class FreeRanges {
 public:
  explicit FreeRanges(std::uint32_t size);

  /// Returns the start of the lowest free range of `count` numbers, which is then taken; nullopt if there is none.
  std::optional<std::uint32_t> Take(std::uint32_t count);
  /// Frees a range that Take() returned.
  void Give(std::uint32_t start, std::uint32_t count);
  std::uint32_t free() const { return free_; }

 private:
  std::map<std::uint32_t, std::uint32_t> ranges_;  // free ones: start and length; no two of them touch
  std::uint32_t free_;
};

}  // namespace kerf
