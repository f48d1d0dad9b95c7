#include "view/plot/clip.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

constexpr ClipBox kBox{0, 0, 10, 5};

TEST(ClipSegment, ReturnsThePartInside) {
  const auto across = ClipSegment({-10, 2}, {30, 2}, kBox);
  ASSERT_TRUE(across);
  EXPECT_DOUBLE_EQ(across->from, 0.25);
  EXPECT_DOUBLE_EQ(across->to, 0.5);
  const auto inside = ClipSegment({1, 1}, {2, 4}, kBox);
  ASSERT_TRUE(inside);
  EXPECT_EQ(inside->from, 0);
  EXPECT_EQ(inside->to, 1);
}

TEST(ClipSegment, ReturnsNoPartOutside) {
  EXPECT_FALSE(ClipSegment({-10, 6}, {30, 6}, kBox));  // parallel to an edge
  const auto past_a_corner = ClipSegment({-1, 4}, {2, 8}, kBox);
  ASSERT_TRUE(past_a_corner);
  EXPECT_GT(past_a_corner->from, past_a_corner->to);
}

}  // namespace
}  // namespace kerf
