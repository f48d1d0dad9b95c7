#include "base/core/byte_text.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(FormatBytePair, DifferentNumbersGiveDifferentText) {
  using Pair = std::pair<std::string, std::string>;
  EXPECT_EQ(FormatBytePair(40e6, 2.1e6), Pair("40.0 MB", "2.1 MB"));
  EXPECT_EQ(FormatBytePair(100e3, 40.96e3), Pair("100.0 kB", "41.0 kB"));
  EXPECT_EQ(FormatBytePair(0.54e9, 0.51e9), Pair("540.0 MB", "510.0 MB"));
  EXPECT_EQ(FormatBytePair(2.04e9, 2.01e9), Pair("2.04 GB", "2.01 GB"));
  EXPECT_EQ(FormatBytePair(1000, 999), Pair("1.000 kB", "0.999 kB"));
  // Equal numbers give equal text.
  const Pair same = FormatBytePair(5e6, 5e6);
  EXPECT_EQ(same.first, same.second);
}

}  // namespace
}  // namespace kerf
