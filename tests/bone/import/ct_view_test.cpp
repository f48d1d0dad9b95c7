// Views of a CT, in which each pixel is a known point of the patient.
#include "bone/import/ct_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/trigonometric.hpp>
#include <numbers>

#include "ct_files.h"
#include "kerf/error.h"

namespace kerf {
namespace {

const Rgb8& PixelAt(const CtView& view, int row, int column) {
  return view.pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(view.columns) +
                     static_cast<std::size_t>(column)];
}

// A ball far from the origin, in an oblique lattice with a different spacing in each direction.
const Vec3 kBall_W(12, -230, 371);
constexpr double kRadius_mm = 10;

Volume ObliqueBall() {
  const double a = glm::radians(20.0);
  const double b = glm::radians(-15.0);
  const glm::dmat3 about_z(Vec3(std::cos(a), std::sin(a), 0), Vec3(-std::sin(a), std::cos(a), 0), Vec3(0, 0, 1));
  const glm::dmat3 about_x(Vec3(1, 0, 0), Vec3(0, std::cos(b), std::sin(b)), Vec3(0, -std::sin(b), std::cos(b)));
  const glm::dmat3 axes_W = about_z * about_x;
  const std::array<int, 3> size = {60, 75, 30};
  const Vec3 spacing_mm(0.8, 0.6, 1.5);
  const Vec3 half = 0.5 * Vec3(size[0] - 1, size[1] - 1, size[2] - 1) * spacing_mm;
  return test::MakeCt(size, spacing_mm, kBall_W - axes_W * half, axes_W, test::Ball(kBall_W, kRadius_mm), 1000);
}

CtViewOptions Around(const Vec3& centre_W) {
  CtViewOptions options;
  options.box_W.Include(centre_W - Vec3(14, 13, 12));
  options.box_W.Include(centre_W + Vec3(11, 15, 12));
  options.iso_hu = 500;
  return options;
}

// Centre, in patient coordinates, and area of the pixels that are drawn as bone (in a warm colour).
struct Spot {
  double across = 0, down = 0, mm2 = 0;
};
Spot FindBone(const CtView& view) {
  Spot spot;
  int count = 0;
  for (int row = 0; row < view.rows; ++row) {
    for (int column = 0; column < view.columns; ++column) {
      const Rgb8& p = PixelAt(view, row, column);
      if (p[0] < p[2] + 10) continue;
      ++count;
      spot.across += view.left_mm + (column + 0.5) / view.columns * (view.right_mm - view.left_mm);
      spot.down += view.top_mm + (row + 0.5) / view.rows * (view.bottom_mm - view.top_mm);
    }
  }
  spot.across /= count, spot.down /= count;
  spot.mm2 =
      count * std::abs((view.right_mm - view.left_mm) / view.columns * (view.bottom_mm - view.top_mm) / view.rows);
  return spot;
}

TEST(CtView, BallIsAtItsPositionInEachSlice) {
  const Volume ct = ObliqueBall();
  const CtViewOptions options = Around(kBall_W);
  for (const CtAxis axis : {CtAxis::kX, CtAxis::kY, CtAxis::kZ}) {
    const int a = static_cast<int>(axis);
    const int across = axis == CtAxis::kX ? 1 : 0;
    const int down = axis == CtAxis::kZ ? 1 : 2;
    for (const double off_mm : {0.0, 6.0}) {
      const CtView view = DrawCtSlice(ct, axis, kBall_W[a] + off_mm, options);
      const Spot spot = FindBone(view);
      const double mm2 = std::numbers::pi * (kRadius_mm * kRadius_mm - off_mm * off_mm);
      // The plane cuts the ball in a circle. Trilinear interpolation between voxels of up to 1.5 mm gives its radius to
      // 0.1 mm.
      EXPECT_NEAR(spot.across, kBall_W[across], 0.1) << a;
      EXPECT_NEAR(spot.down, kBall_W[down], 0.1) << a;
      EXPECT_NEAR(spot.mm2, mm2, 2 * std::numbers::pi * kRadius_mm * 0.1 + 1) << a;
    }
    EXPECT_LT(DrawCtSlice(ct, axis, kBall_W[a], options).left_mm, kBall_W[across]);
  }
}

// The head is at the top, and in axial slices the patient's back is at the bottom, as in a scanner's pictures.
TEST(CtView, AxesFollowTheRadiologicalConvention) {
  const CtViewOptions options = Around(kBall_W);
  const Volume ct = ObliqueBall();
  const CtView axial = DrawCtSlice(ct, CtAxis::kZ, kBall_W.z, options);
  EXPECT_LT(axial.left_mm, axial.right_mm);
  EXPECT_LT(axial.top_mm, axial.bottom_mm);
  for (const CtAxis axis : {CtAxis::kX, CtAxis::kY}) {
    const CtView view = DrawCtSlice(ct, axis, kBall_W[static_cast<int>(axis)], options);
    EXPECT_LT(view.left_mm, view.right_mm);
    EXPECT_GT(view.top_mm, view.bottom_mm);
  }
}

// The surface of a ball is a full disc, brightest in its middle, and nearer surfaces hide those behind.
TEST(CtView, SurfaceViewShowsTheNearestSurface) {
  const CtViewOptions options = Around(kBall_W);
  for (const CtAxis axis : {CtAxis::kX, CtAxis::kY, CtAxis::kZ}) {
    const Spot spot = FindBone(DrawCtSurface(ObliqueBall(), axis, options));
    EXPECT_NEAR(spot.across, kBall_W[axis == CtAxis::kX ? 1 : 0], 0.15);
    EXPECT_NEAR(spot.down, kBall_W[axis == CtAxis::kZ ? 1 : 2], 0.15);
    EXPECT_NEAR(spot.mm2, std::numbers::pi * kRadius_mm * kRadius_mm, 2 * std::numbers::pi * kRadius_mm * 0.15 + 1);
  }
  // A ball of 3 mm in front of one of 6 mm; seen from the side, they are next to each other.
  const Vec3 back(0, 10, 0);
  const Vec3 front(0, -5, 0);
  const auto distance = [&](const Vec3& p) { return std::min(test::Ball(back, 6)(p), test::Ball(front, 3)(p)); };
  const Volume ct = test::MakeCt({30, 40, 30}, {1, 1, 1}, {-15, -15, -15}, glm::dmat3(1), distance, 1000);
  CtViewOptions both;
  both.box_W.Include(Vec3(-10, -10, -10));
  both.box_W.Include(Vec3(10, 18, 10));
  both.iso_hu = 500;
  EXPECT_NEAR(FindBone(DrawCtSurface(ct, CtAxis::kY, both)).mm2, std::numbers::pi * 36, 8);
  EXPECT_NEAR(FindBone(DrawCtSurface(ct, CtAxis::kX, both)).mm2, std::numbers::pi * (36 + 9), 10);
  const CtView view = DrawCtSurface(ct, CtAxis::kY, both);
  const auto brightness = [&](double x, double z) {
    const int column = static_cast<int>((x - view.left_mm) / (view.right_mm - view.left_mm) * view.columns);
    const int row = static_cast<int>((z - view.top_mm) / (view.bottom_mm - view.top_mm) * view.rows);
    return PixelAt(view, row, column)[1];
  };
  EXPECT_GT(brightness(0, 0), brightness(3.3, 0) + 5);  // on the near ball, and on the far ball
  EXPECT_GT(brightness(3.3, 0), brightness(5.5, 0) + 5);
}

TEST(CtView, BoxContainsTheBoneAndStaysWithinTheScan) {
  const Volume ct = ObliqueBall();
  const Box3 box = FindBoneBox(ct, 500, "ball");
  for (int a = 0; a < 3; ++a) {
    EXPECT_LE(box.lower[a], kBall_W[a] - kRadius_mm);
    EXPECT_GE(box.upper[a], kBall_W[a] + kRadius_mm);
    // The box extends beyond the ball by 5 mm, plus the distance that the corners of an oblique box of voxels stick
    // out, up to sqrt(3) - 1 of the radius.
    EXPECT_GE(box.lower[a], kBall_W[a] - 1.8 * kRadius_mm - 5);
  }
  // A table is 2 cm behind the ball; its middle is more than 10 mm from the ball's box.
  const auto table = [](const Vec3& p) {
    return std::max({std::abs(p.x) - 30, std::abs(p.y - 48) - 4, std::abs(p.z) - 10});
  };
  const auto distance = [&](const Vec3& p) { return std::min(test::Ball({0, 0, 0}, 20)(p), table(p)); };
  const Volume with_table = test::MakeCt({40, 50, 30}, {2, 2, 2}, {-40, -40, -30}, glm::dmat3(1), distance, 1000);
  EXPECT_LT(FindBoneBox(with_table, 500, "table").upper.y, 30);
  Volume small = ct;
  small.hu.assign(small.count(), -1000);
  EXPECT_THROW(FindBoneBox(small, 300, "air"), Error);
}

TEST(CtView, SliceOfTheWholeScanHasTheGreysOfItsNumbers) {
  // HU = 10 x + 100 z, exactly linear, so that the interpolated value of each pixel is known.
  Volume ct;
  ct.size = {40, 30, 20};
  ct.spacing_mm = {0.5, 0.7, 1.1};
  ct.origin_W = {-3, 40, -200};
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 30; ++j) {
      for (int i = 0; i < 40; ++i) {
        const Vec3 p = ct.WorldFromVoxel({i, j, k}) - ct.origin_W;
        ct.hu.push_back(static_cast<std::int16_t>(std::lround(10 * p.x + 100 * p.z)));
      }
    }
  }
  const Box3 box = CalcScanBox(ct);
  EXPECT_LT(glm::length(box.lower - (ct.origin_W - 0.5 * ct.spacing_mm)), 1e-12);
  EXPECT_LT(glm::length(box.size() - Vec3(20, 21, 22)), 1e-12);
  const CtGreys greys{.level_HU = 1000, .width_HU = 2000};
  const CtView view = SliceVolume(ct, CtAxis::kY, 50, greys, 0.5);
  EXPECT_EQ(view.columns, 40);
  EXPECT_EQ(view.rows, 44);
  for (int row = 0; row < view.rows; ++row) {
    for (int column = 0; column < view.columns; ++column) {
      const double x = view.left_mm + (column + 0.5) / view.columns * (view.right_mm - view.left_mm) - ct.origin_W.x;
      const double z = view.top_mm + (row + 0.5) / view.rows * (view.bottom_mm - view.top_mm) - ct.origin_W.z;
      if (z < 0 || z > 19 * 1.1) continue;  // beyond the outermost centres the values do not change
      const Rgb8& p = PixelAt(view, row, column);
      EXPECT_EQ(p[0], p[1]);
      // The numbers are rounded to 0.5 HU, the greys to 4 HU.
      EXPECT_NEAR(p[0], std::clamp((10 * x + 100 * z) / 2000, 0.0, 1.0) * 255, 0.6) << row << " " << column;
    }
  }
  // Outside the scan everything is black.
  for (const Rgb8& p : SliceVolume(ct, CtAxis::kY, 30, {.level_HU = -5000, .width_HU = 10}).pixels) {
    EXPECT_EQ(p, (Rgb8{0, 0, 0}));
  }
}

TEST(CtView, ValuesFromAThresholdOnAreTinted) {
  // The edge of the ball is blurred over a voxel, so half its value is met at its radius.
  const Volume ct = ObliqueBall();
  const CtView view = SliceVolume(ct, CtAxis::kZ, kBall_W.z, {.level_HU = 0, .width_HU = 3000, .tinted_from = 500});
  const Spot spot = FindBone(view);
  const double mm2 = std::numbers::pi * kRadius_mm * kRadius_mm;
  EXPECT_NEAR(spot.across, kBall_W.x, 0.1);
  EXPECT_NEAR(spot.mm2, mm2, 2 * std::numbers::pi * kRadius_mm * 0.1 + 1);
  for (const Rgb8& p : SliceVolume(ct, CtAxis::kZ, kBall_W.z, {}).pixels) ASSERT_TRUE(p[0] == p[1] && p[1] == p[2]);
}

}  // namespace
}  // namespace kerf
