#include "view/live/free_ranges.h"

#include <iterator>

namespace kerf {

FreeRanges::FreeRanges(std::uint32_t size) : free_(size) {
  if (size > 0) ranges_[0] = size;
}

std::optional<std::uint32_t> FreeRanges::Take(std::uint32_t count) {
  for (auto range = ranges_.begin(); range != ranges_.end(); ++range) {
    const auto [start, length] = *range;
    if (length < count) continue;
    ranges_.erase(range);
    if (length > count) ranges_[start + count] = length - count;
    free_ -= count;
    return start;
  }
  return std::nullopt;
}

void FreeRanges::Give(std::uint32_t start, std::uint32_t count) {
  if (count == 0) return;
  free_ += count;
  auto next = ranges_.upper_bound(start);
  if (next != ranges_.begin()) {
    const auto previous = std::prev(next);
    if (previous->first + previous->second == start) {
      start = previous->first;
      count += previous->second;
      ranges_.erase(previous);
    }
  }
  if (next != ranges_.end() && start + count == next->first) {
    count += next->second;
    ranges_.erase(next);
  }
  ranges_[start] = count;
}

}  // namespace kerf
