#include "base/core/nearest_name.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(NearestName, EditDistanceHasItsTextbookValues) {
  EXPECT_EQ(CalcEditDistance("kitten", "sitting"), 3u);
  EXPECT_EQ(CalcEditDistance("", "abc"), 3u);
  EXPECT_EQ(CalcEditDistance("abc", ""), 3u);
  EXPECT_EQ(CalcEditDistance("same", "same"), 0u);
}

TEST(NearestName, FindsTheNearestNameOrNone) {
  const std::vector<std::string> names = {"diameter_mm", "thickness_mm", "nu", "teeth"};
  EXPECT_EQ(FindNearestName("diamter_mm", names), "diameter_mm");
  EXPECT_EQ(FindNearestName("Teeth", names), "teeth");
  EXPECT_EQ(FindNearestName("temperature", names), "");
  EXPECT_EQ(FindNearestName("xy", names), "");
  EXPECT_EQ(FindNearestName("", names), "");
}

}  // namespace
}  // namespace kerf
