// Tests of slices of a CT whose number is known at each point.
#include "view/live/ct_slices.h"

#include <gtest/gtest.h>

#include <cmath>

#include "bone/grid/ct_modulus.h"
#include "kerf/error.h"
#include "support/chunks.h"

namespace kerf {
namespace {

// Returns a plate whose CT numbers grow along x, by 100 HU per mm.
Bone MakePlateWithCt() {
  Bone bone = test::MakePlate(0.25);
  SetHu(
      bone, [](const Vec3& p) { return 600 + 100 * p.x; }, 0.25);
  return bone;
}

constexpr Rgb8 kBoneLine{255, 200, 40};
constexpr Rgb8 kToolLine{80, 200, 255};

TEST(CtSlices, GreyMatchesTheCtNumberAndLinesTheOutlines) {
  const Bone bone = MakePlateWithCt();
  DiscSaw saw;
  saw.diameter_mm = 6;
  saw.thickness_mm = 1;
  // The disc is upright: its plane is y = 0.2, and the spindle points along y.
  Pose X_WT;
  X_WT.R_AB = glm::angleAxis(-1.5707963267948966, Vec3{1, 0, 0});
  X_WT.p_AB = {1, 0.2, -2};
  constexpr int kPixels = 200;
  constexpr double kEdge_mm = 24;
  const CtSlices slices = CalcCtSlices(bone, saw, X_WT, kEdge_mm, kPixels, {600, 2000});
  const CtSlice& blade = slices.slices[0];
  EXPECT_EQ(blade.up_letter, "S");
  EXPECT_NEAR(blade.up_W.z, 1, 1e-9);
  const double pixel_mm = kEdge_mm / kPixels;
  std::size_t grey = 0;
  std::size_t bone_line = 0;
  std::size_t tool_line = 0;
  for (int row = 0; row < kPixels; ++row) {
    for (int column = 0; column < kPixels; ++column) {
      const Vec3 p = X_WT.p_AB + ((column + 0.5) * pixel_mm - 0.5 * kEdge_mm) * blade.right_W +
                     (0.5 * kEdge_mm - (row + 0.5) * pixel_mm) * blade.up_W;
      EXPECT_NEAR(p.y, 0.2, 1e-9);
      // Distances to the rectangle of 16 x 10 mm and to the circle of 3 mm.
      const double to_edge = std::min({8 - std::abs(p.x), -p.z, p.z + 10});
      const double to_tool = std::hypot(p.x - 1, p.z + 2) - 3;
      const Rgb8& seen = blade.image.At(column, row);
      if (std::abs(to_tool) < 0.4 * pixel_mm) {
        ASSERT_EQ(seen, kToolLine);
        ++tool_line;
      } else if (std::abs(to_edge) < 0.4 * pixel_mm && std::abs(to_tool) > pixel_mm) {
        ASSERT_EQ(seen, kBoneLine);
        ++bone_line;
      } else if (to_edge > 0.5 && std::abs(to_tool) > 2 * pixel_mm) {
        // A window of 2000 HU about 600 gives 127.5 at x = 0 and 12.75 more per mm. The tolerance is half a step of
        // rounding, and the rounding of the CT's floats.
        ASSERT_NEAR(seen[0], 127.5 + 12.75 * p.x, 0.6);
        ASSERT_EQ(seen[0], seen[1]);
        ++grey;
      }
    }
  }
  EXPECT_GT(grey, 5000u);
  EXPECT_GT(bone_line, 200u);
  EXPECT_GT(tool_line, 60u);
  // In the perpendicular slice the disc is a bar as thick as the blade.
  const CtSlice& across = slices.slices[1];
  const int middle_row = kPixels / 2;
  std::vector<double> edges;
  for (int column = 0; column < kPixels; ++column) {
    if (across.image.At(column, middle_row) == kToolLine) edges.push_back((column + 0.5) * pixel_mm - 0.5 * kEdge_mm);
  }
  ASSERT_FALSE(edges.empty());
  EXPECT_NEAR(edges.front(), -0.5, pixel_mm);
  EXPECT_NEAR(edges.back(), 0.5, pixel_mm);
}

TEST(CtSlices, RefusesInvalidInput) {
  const Bone bone = MakePlateWithCt();
  EXPECT_THROW(CalcCtSlices(test::MakePlate(0.5), DiscSaw{}, {}, 20, 100), Error);
  EXPECT_THROW(CalcCtSlices(bone, DiscSaw{}, {}, 0, 100), Error);
  EXPECT_THROW(CalcCtSlices(bone, DiscSaw{}, {}, 20, 2), Error);
  EXPECT_THROW(CalcCtSlices(bone, DiscSaw{}, {}, 20, 100, {0, 0}), Error);
}

}  // namespace
}  // namespace kerf
