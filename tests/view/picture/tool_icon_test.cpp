// Tests of the small pictures of tools.
#include "view/picture/tool_icon.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace kerf {
namespace {

struct Covered {
  int left = 1000, right = -1, top = 1000, bottom = -1, count = 0;
};

/// Returns where a picture differs from its corner.
Covered FindTool(const Image& image) {
  Covered covered;
  for (int row = 0; row < image.height; ++row) {
    for (int column = 0; column < image.width; ++column) {
      if (image.At(column, row) == image.At(0, 0)) continue;
      covered.left = std::min(covered.left, column);
      covered.right = std::max(covered.right, column);
      covered.top = std::min(covered.top, row);
      covered.bottom = std::max(covered.bottom, row);
      ++covered.count;
    }
  }
  return covered;
}

TEST(ToolIcon, ShowsEachToolWholeAndAsLargeAsItFits) {
  for (const Tool& tool : {Tool(DiscSaw{}), Tool(BallBurr{}), Tool(FissureBur{}), Tool(TwistDrill{}),
                           Tool(ReciprocatingBlade{}), Tool(OscillatingBlade{}), Tool(PiezoInsert{})}) {
    const Image image = DrawToolIcon(tool, 120, 60);
    ASSERT_EQ(image.pixels.size(), 120u * 60u);
    const Covered covered = FindTool(image);
    EXPECT_GT(covered.left, 0) << DescribeTool(tool);
    EXPECT_LT(covered.right, 119) << DescribeTool(tool);
    EXPECT_GT(covered.top, 0) << DescribeTool(tool);
    EXPECT_LT(covered.bottom, 59) << DescribeTool(tool);
    const bool is_wide = covered.right - covered.left > 110, is_high = covered.bottom - covered.top > 50;
    EXPECT_TRUE(is_wide || is_high) << DescribeTool(tool);
    EXPECT_NEAR(covered.left + covered.right, 119, 3) << DescribeTool(tool);
  }
}

TEST(ToolIcon, HasTheToolsProportions) {
  const Covered disc = FindTool(DrawToolIcon(DiscSaw{}, 120, 120));
  EXPECT_NEAR(disc.right - disc.left, disc.bottom - disc.top, 3);
  EXPECT_NEAR(disc.count, std::numbers::pi / 4 * 106 * 106, 0.1 * std::numbers::pi / 4 * 106 * 106);
  const Covered blade = FindTool(DrawToolIcon(ReciprocatingBlade{}, 120, 120));  // 30 x 6 mm
  EXPECT_NEAR((blade.right - blade.left) / static_cast<double>(blade.bottom - blade.top), 5, 0.6);
}

}  // namespace
}  // namespace kerf
