#include "view/live/free_ranges.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <utility>
#include <vector>

namespace kerf {
namespace {

TEST(FreeRanges, TakenRangesNeverOverlapAndAllIsFreeAgainInTheEnd) {
  constexpr std::uint32_t kSize = 1000;
  FreeRanges ranges(kSize);
  std::vector<bool> taken(kSize, false);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> held;
  std::mt19937 random(7);
  std::uint32_t refused = 0;
  const auto give = [&](std::size_t i) {
    const auto [start, count] = held[i];
    for (std::uint32_t k = start; k < start + count; ++k) taken[k] = false;
    ranges.Give(start, count);
    held.erase(held.begin() + static_cast<std::ptrdiff_t>(i));
  };
  for (int step = 0; step < 5000; ++step) {
    if (random() % 3 == 0 && !held.empty()) {
      give(random() % held.size());
      continue;
    }
    const auto count = static_cast<std::uint32_t>(1 + random() % 90);
    const std::optional<std::uint32_t> start = ranges.Take(count);
    if (!start) {
      ++refused;
      give(random() % held.size());
      continue;
    }
    ASSERT_LE(*start + count, kSize);
    for (std::uint32_t k = *start; k < *start + count; ++k) {
      ASSERT_FALSE(taken[k]) << "number " << k << " in step " << step;
      taken[k] = true;
    }
    held.emplace_back(*start, count);
    std::uint32_t sum = 0;
    for (const auto& [first, length] : held) sum += length;
    ASSERT_EQ(ranges.free(), kSize - sum);
  }
  EXPECT_GT(refused, 0u);  // it was full at times
  while (!held.empty()) give(random() % held.size());
  // Neighbours were joined again, so that all of it is one range.
  EXPECT_EQ(ranges.Take(kSize), 0u);
  EXPECT_EQ(ranges.Take(1), std::nullopt);
}

}  // namespace
}  // namespace kerf
