// Tests of the outlines of wanted and made cuts, with exact cuts whose outlines are known.
#include "session/score/cut_picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr double kCell_mm = 0.25;
/// Flat walls are placed to a tenth of a voxel.
constexpr double kWall_mm = 0.1 * kCell_mm;
/// Edges are rounded by up to half a voxel.
constexpr double kEdge_mm = 0.5 * kCell_mm;

/// A block of 30 x 16 x 8 mm below z = 0, with a line of 6 mm on its top.
struct Scenario {
  BlockParams block;
  WantedCut wanted;
};

Scenario MakeScenario(double thickness_mm = 0.5) {
  Scenario scenario;
  scenario.block.size_mm = {30, 16, 8};
  scenario.block.voxel_mm = kCell_mm;
  SceneExercise exercise;
  exercise.start_mm = {-3, 0, 0};
  exercise.end_mm = {3, 0, 0};
  exercise.into = {0, 0, -1};
  exercise.depth_mm = 2;
  DiscSaw saw;
  saw.diameter_mm = 12;
  saw.thickness_mm = thickness_mm;
  scenario.wanted = MakeWantedCut(exercise, saw);
  return scenario;
}

Bone CutBlock(const BlockParams& block, const WantedCut& cut) {
  SolidField solid;
  solid.value = [&](const Vec3& p_W) { return std::max(CalcBlockDistance(block, p_W), -cut.CalcDistance(p_W)); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3&) { return 24; };
  Box3 box;
  box.Include({-15, -8, -8});
  box.Include({15, 8, 0});
  BuildOptions options;
  options.voxel_mm = block.voxel_mm;
  options.region_voxel_mm = block.voxel_mm;
  return MakeBone(solid, box.Grown(2), options, DefaultMandibleTable());
}

CutPicture MakePictureOf(const Scenario& scenario, const WantedCut& made) {
  const Bone before = MakeBlock(scenario.block, DefaultMandibleTable());
  const Bone after = CutBlock(scenario.block, made);
  return MakeCutPicture(before, after, scenario.wanted, FindRemoved(before, after));
}

struct Extent {
  double left = 1e9, right = -1e9, bottom = 1e9, top = -1e9;
};
Extent ExtentOf(const std::vector<PictureLine>& lines) {
  Extent e;
  for (const PictureLine& line : lines) {
    for (const PicturePoint& p : line) {
      e = {std::min(e.left, p.x_mm), std::max(e.right, p.x_mm), std::min(e.bottom, p.y_mm), std::max(e.top, p.y_mm)};
    }
  }
  return e;
}

/// Returns the enclosed area of closed lines.
double AreaOf(const std::vector<PictureLine>& lines) {
  double area = 0;
  for (const PictureLine& line : lines) {
    EXPECT_EQ(line.front(), line.back()) << "not closed";
    double twice = 0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      twice += line[i].x_mm * line[i + 1].y_mm - line[i + 1].x_mm * line[i].y_mm;
    }
    area += std::abs(0.5 * twice);
  }
  return area;
}

/// Length of the kerf beyond an end of the line: half of the disc's chord at a depth.
double HalfChord(const WantedCut& cut, double at_depth_mm) {
  const double up = cut.radius_mm - cut.depth_mm + at_depth_mm;
  return std::sqrt(cut.radius_mm * cut.radius_mm - up * up);
}

TEST(CutPicture, ExactCutCoversTheWantedOne) {
  const Scenario scenario = MakeScenario();
  const CutPicture picture = MakePictureOf(scenario, scenario.wanted);
  double chord_mm = HalfChord(scenario.wanted, kCell_mm);  // the first voxel is not shown
  for (const auto* lines : {&picture.above.wanted, &picture.above.made}) {
    ASSERT_EQ(lines->size(), 1U);
    const Extent e = ExtentOf(*lines);
    EXPECT_NEAR(e.left, -chord_mm, kEdge_mm);
    EXPECT_NEAR(e.right, 6 + chord_mm, kEdge_mm);
    EXPECT_NEAR(e.bottom, -0.25, kWall_mm);
    EXPECT_NEAR(e.top, 0.25, kWall_mm);
    // A rectangle with edges rounded by half a voxel.
    EXPECT_NEAR(AreaOf(*lines), 0.5 * (6 + 2 * chord_mm), 2 * kEdge_mm * 0.5 + 2 * kWall_mm * (6 + 2 * chord_mm));
  }
  chord_mm = HalfChord(scenario.wanted, 0);
  for (const auto* lines : {&picture.side.wanted, &picture.side.made}) {
    const Extent e = ExtentOf(*lines);
    EXPECT_NEAR(e.bottom, -2, kWall_mm);
    EXPECT_NEAR(e.top, 0, kEdge_mm);
    EXPECT_NEAR(e.left, -chord_mm, kEdge_mm);
    // The wanted depth times the line, and two halves of a segment of the disc.
    const double r = scenario.wanted.radius_mm;
    const double segment = r * r * std::acos((r - 2) / r) - (r - 2) * chord_mm;
    EXPECT_NEAR(AreaOf(*lines), 2 * 6 + segment, 0.03 * (2 * 6 + segment));
  }
  EXPECT_EQ(picture.above.line, (PictureLine{{0, 0}, {6, 0}}));
}

TEST(CutPicture, DisplacedGrooveIsDrawnWhereItLies) {
  for (const double thickness_mm : {0.5, 1.0}) {
    const Scenario scenario = MakeScenario(thickness_mm);
    for (const double offset_mm : {3.1, -1.7}) {
      WantedCut made = scenario.wanted;
      made.start_W += offset_mm * made.across_W + 0.6 * made.along_W + 0.7 * made.into_W;
      const CutPicture picture = MakePictureOf(scenario, made);
      const Extent above = ExtentOf(picture.above.made);
      EXPECT_NEAR(0.5 * (above.bottom + above.top), offset_mm, kWall_mm);
      EXPECT_NEAR(above.top - above.bottom, thickness_mm, 2 * kWall_mm);
      EXPECT_NEAR(0.5 * (above.left + above.right), 3 + 0.6, kEdge_mm);
      EXPECT_NEAR(ExtentOf(picture.side.made).bottom, -2.7, kWall_mm);
      // Both are within what is shown.
      EXPECT_LT(picture.above.left_mm, above.left);
      EXPECT_GT(picture.above.top_mm, std::max(above.top, 0.25));
      EXPECT_LT(picture.above.bottom_mm, std::min(above.bottom, -0.25));
    }
  }
}

TEST(CutPicture, TurnedGrooveHasTheAngleOfTheTurn) {
  const Scenario scenario = MakeScenario();
  WantedCut made = scenario.wanted;
  const Quat turn = glm::angleAxis(0.1, made.into_W);
  made.along_W = turn * made.along_W;
  made.across_W = turn * made.across_W;
  const CutPicture picture = MakePictureOf(scenario, made);
  ASSERT_EQ(picture.above.made.size(), 1U);
  // The turn is positive about the direction into the picture. Slope of the regression line through the outline of a
  // long, narrow rectangle.
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (const PicturePoint& p : picture.above.made.front()) {
    n += 1;
    sx += p.x_mm;
    sy += p.y_mm;
    sxx += p.x_mm * p.x_mm;
    sxy += p.x_mm * p.y_mm;
  }
  EXPECT_NEAR((n * sxy - sx * sy) / (n * sxx - sx * sx), -std::tan(0.1), 0.005);
}

// No line of it is the border of what was searched, and the bone's ends, which are near, are shown.
TEST(CutPicture, OutlineOfTheBoneIsItsSurface) {
  const Scenario scenario = MakeScenario();
  const CutPicture picture = MakePictureOf(scenario, scenario.wanted);
  const auto check = [](const CutView& view, double bottom_mm, double top_mm) {
    ASSERT_FALSE(view.bone.empty());
    for (const PictureLine& line : view.bone) {
      for (const PicturePoint& p : line) {
        const double distance = std::max(std::abs(p.x_mm) - 15, std::max(bottom_mm - p.y_mm, p.y_mm - top_mm));
        EXPECT_NEAR(distance, 0, kEdge_mm) << p.x_mm << ", " << p.y_mm;
      }
    }
    EXPECT_LT(view.left_mm, -15);
    EXPECT_GT(view.right_mm, 15);
  };
  // The line begins at x = -3 of the block.
  const auto shifted = [](CutView view) {
    for (PictureLine& line : view.bone) {
      for (PicturePoint& p : line) p.x_mm -= 3;
    }
    view.left_mm -= 3;
    view.right_mm -= 3;
    return view;
  };
  check(shifted(picture.above), -8, 8);
  check(shifted(picture.side), -8, 0);
}

TEST(CutPicture, WithoutACutOnlyTheWantedOneIsDrawn) {
  const Scenario scenario = MakeScenario();
  const Bone before = MakeBlock(scenario.block, DefaultMandibleTable());
  const CutPicture picture = MakeCutPicture(before, before, scenario.wanted, {});
  EXPECT_TRUE(picture.above.made.empty());
  EXPECT_FALSE(picture.above.wanted.empty());
}

TEST(CutPicture, IsDrawnWithEqualScales) {
  const Scenario scenario = MakeScenario();
  WantedCut made = scenario.wanted;
  made.start_W += 3.1 * made.across_W;
  const CutPicture picture = MakePictureOf(scenario, made);
  EXPECT_GT(picture.scale_bar_mm, 0);
  EXPECT_LE(picture.scale_bar_mm, (picture.above.right_mm - picture.above.left_mm) / 3);
  PlotFrame frame{};
  const std::string svg = FormatCutViewSvg(picture.above, AboveTexts(), 800, &frame);
  const double x_scale = (frame.right - frame.left) / (frame.x_upper - frame.x_lower);
  const double y_scale = (frame.bottom - frame.top) / (frame.y_upper - frame.y_lower);
  EXPECT_NEAR(y_scale, x_scale, 0.01 * x_scale);  // sizes in pixels are integers
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  EXPECT_THAT(svg, testing::HasSubstr("Your cut from above"));
  EXPECT_THAT(svg, testing::HasSubstr("wanted"));
  EXPECT_THAT(svg, testing::HasSubstr("made"));
  EXPECT_THAT(svg, testing::Not(testing::HasSubstr("http")));
}

}  // namespace
}  // namespace kerf
