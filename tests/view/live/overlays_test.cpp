// Tests of overlays: places of labels, levels of alarms, the free area, and what is visible through bone.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "view/live/flat_overlays.h"
#include "view/live/nearest.h"
#include "view/live/scene_actors.h"
#include "view/live/scene_shapes.h"

namespace kerf {
namespace {

double Draw(std::mt19937& random, double lower, double upper) {
  return lower + (upper - lower) * (static_cast<double>(random()) / 4294967296.0);
}

TEST(Labels, OverlapNeitherPanelsNorEachOther) {
  std::mt19937 random(3);
  const std::vector<FlatBox> panels{{0, 0, 240, 700}, {1100, 0, 180, 500}, {400, 10, 500, 40}};
  for (int round = 0; round < 50; ++round) {
    std::vector<FlatLabel> labels;
    for (int i = 0; i < 12; ++i) {
      labels.push_back({"label " + std::to_string(i), Draw(random, -20, 1300), Draw(random, -20, 740), {}});
    }
    const auto places = PlaceLabels(labels, panels, {}, 1280, 720);
    EXPECT_GT(places.size(), 6u);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const FlatBox& box = places[i].box;
      EXPECT_GE(box.left, 0);
      EXPECT_GE(box.top, 0);
      EXPECT_LE(box.right(), 1280);
      EXPECT_LE(box.bottom(), 720);
      for (const FlatBox& panel : panels) EXPECT_FALSE(Overlap(panel, box));
      for (std::size_t j = 0; j < i; ++j) EXPECT_FALSE(Overlap(places[j].box, box));
    }
  }
}

TEST(Labels, AvoidTheSawIfThereIsSpace) {
  const FlatBox saw{600, 300, 120, 120};
  const std::vector<FlatLabel> labels{{"12.3 N on your hand", 660, 360, {}}};
  const auto beside = PlaceLabels(labels, {}, {saw}, 1280, 720);
  ASSERT_EQ(beside.size(), 1u);
  EXPECT_FALSE(Overlap(beside[0].box, saw));
  // If the saw covers the whole window, the label is shown all the same.
  EXPECT_EQ(PlaceLabels(labels, {}, {{0, 0, 1280, 720}}, 1280, 720).size(), 1u);
}

TEST(FreeArea, IsTheLargestWithoutPanels) {
  std::mt19937 random(5);
  for (int round = 0; round < 40; ++round) {
    std::vector<FlatBox> boxes;
    // Whole numbers, so that brute force over whole numbers finds the largest area too.
    constexpr int kWidth = 24;
    constexpr int kHeight = 16;
    for (int i = 0; i < 4; ++i) {
      boxes.push_back({std::floor(Draw(random, -2, kWidth)), std::floor(Draw(random, -2, kHeight)),
                       std::floor(Draw(random, 1, 9)), std::floor(Draw(random, 1, 7))});
    }
    double best = 0;
    for (int l = 0; l < kWidth; ++l) {
      for (int r = l + 1; r <= kWidth; ++r) {
        for (int t = 0; t < kHeight; ++t) {
          for (int b = t + 1; b <= kHeight; ++b) {
            const FlatBox box{1.0 * l, 1.0 * t, 1.0 * (r - l), 1.0 * (b - t)};
            const double area = box.width * box.height;
            if (area <= best) continue;
            if (std::none_of(boxes.begin(), boxes.end(), [&](const FlatBox& o) { return Overlap(o, box); }))
              best = area;
          }
        }
      }
    }
    const FlatBox found = FindFreeArea(boxes, kWidth, kHeight);
    EXPECT_DOUBLE_EQ(found.width * found.height, best);
    for (const FlatBox& box : boxes) EXPECT_FALSE(Overlap(found, box));
  }
  EXPECT_TRUE(FindFreeArea({{0, 0, 100, 100}}, 100, 100).empty());
  EXPECT_EQ(FindFreeArea({}, 100, 50).width, 100);
}

double AreaOf(const DrawList& list, const Rgb8& colour) {
  double area = 0;
  for (const FlatTriangle& t : list.triangles()) {
    if (t.colour.rgb != colour) continue;
    const auto& [a, b, c] = t.corners;
    area += 0.5 * std::abs((b.column - a.column) * (c.row - a.row) - (c.column - a.column) * (b.row - a.row));
  }
  return area;
}

// The level must be readable without colour: the inked area and the radius grow, and the patterns differ.
TEST(Alarms, LevelsDifferInSizeAndPattern) {
  EXPECT_EQ(AlarmRadius(AlarmLevel::kNone), 0);
  double radius = 0;
  double area = 0;
  for (const AlarmLevel level : {AlarmLevel::kNotice, AlarmLevel::kWarning, AlarmLevel::kDanger}) {
    EXPECT_GE(AlarmRadius(level), 1.3 * radius);
    radius = AlarmRadius(level);
    DrawList ring;
    AddAlarmRing(100, 100, level, ring);
    const double now = AreaOf(ring, AlarmColour(level));
    EXPECT_GT(now, 1.5 * area);
    area = now;
    EXPECT_GE(AlarmThickness(level), 0);
  }
  DrawList none, notice, warning, danger;
  AddAlarmRing(100, 100, AlarmLevel::kNone, none);
  EXPECT_TRUE(none.steps().empty());
  AddAlarmBorder({0, 0, 400, 300}, AlarmLevel::kNotice, notice);
  EXPECT_TRUE(notice.steps().empty());
  AddAlarmBorder({0, 0, 400, 300}, AlarmLevel::kWarning, warning);
  AddAlarmBorder({0, 0, 400, 300}, AlarmLevel::kDanger, danger);
  // A closed border of this thickness has the area of the frame; a dashed one less.
  const auto frame = [](AlarmLevel level) {
    const double t = AlarmThickness(level);
    return 400 * 300 - (400 - 2 * t) * (300 - 2 * t);
  };
  EXPECT_LT(AreaOf(warning, AlarmColour(AlarmLevel::kWarning)), 0.85 * frame(AlarmLevel::kWarning));
  EXPECT_NEAR(AreaOf(danger, AlarmColour(AlarmLevel::kDanger)), frame(AlarmLevel::kDanger), 1e-6);
  EXPECT_GT(AreaOf(danger, {255, 255, 255}), 0.1 * frame(AlarmLevel::kDanger));
}

TEST(Alarms, LevelGrowsAsTheDistanceShrinks) {
  EXPECT_EQ(AlarmLevelFor(5), AlarmLevel::kNone);
  EXPECT_EQ(AlarmLevelFor(3), AlarmLevel::kNotice);
  EXPECT_EQ(AlarmLevelFor(1.5), AlarmLevel::kWarning);
  EXPECT_EQ(AlarmLevelFor(-0.2), AlarmLevel::kDanger);
}

TEST(Nearest, DistanceToDiscAndBallIsThatOfTheClosedForm) {
  DiscSaw saw;
  saw.diameter_mm = 20;
  saw.thickness_mm = 1;
  const Pose X_WT{glm::angleAxis(0.7, glm::normalize(Vec3{1, 2, 3})), {4, -2, 6}};
  const auto at = [&](const Tool& tool, const Vec3& p_T) {
    TriangleMesh one;
    one.points = {X_WT.Point(p_T), X_WT.Point({200, 0, 0})};
    const auto nearest = FindNearest(tool, X_WT, one);
    EXPECT_NEAR(glm::length(nearest->p_W - one.points[0]), 0, 1e-12);
    return nearest->distance_mm;
  };
  EXPECT_NEAR(at(saw, {3, 4, 2.5}), 2, 1e-12);                       // above the flat
  EXPECT_NEAR(at(saw, {0, 13, 0.2}), 3, 1e-12);                      // beside the rim
  EXPECT_NEAR(at(saw, {13, 0, -4.5}), 5, 1e-12);                     // off the edge: 3, 4, 5
  EXPECT_NEAR(at(saw, {9.8, 0, 0}), -0.2, 1e-12);                    // inside, next to the rim
  EXPECT_NEAR(at(BallBurr{.diameter_mm = 6}, {0, 4, 3}), 2, 1e-12);  // from the centre 5
  EXPECT_FALSE(FindNearest(saw, X_WT, {}));
}

TEST(ForceArrowLength, NeverSpansMoreThanAThirdOfTheView) {
  std::mt19937 random(11);
  for (const bool parallel : {true, false}) {
    for (int i = 0; i < 200; ++i) {
      ViewCamera camera;
      camera.SetSize(1280, 720);
      camera.set_parallel(parallel);
      camera.set_height_mm(Draw(random, 2, 300));
      camera.Look({Draw(random, -1, 1), Draw(random, -1, 1), Draw(random, 0.1, 1)}, {0, 1, 0});
      const Vec3 tip = camera.Unproject({Draw(random, 0, 1280), Draw(random, 0, 720)}, camera.target_W());
      const Vec3 back = glm::normalize(Vec3{Draw(random, -1, 1), Draw(random, -1, 1), Draw(random, -1, 1)});
      const double length = CalcArrowLength(camera, tip, back, 60);
      EXPECT_LE(length, 60);
      const auto a = camera.Project(tip);
      const auto b = camera.Project(tip + length * back);
      ASSERT_TRUE(a && b);
      const double px = std::hypot(a->x - b->x, a->y - b->y);
      EXPECT_LE(px, 240 * (1 + 1e-9));
      // It is not shorter than it must be.
      if (length < 60) {
        EXPECT_GT(px, 239);
      }
    }
  }
}

TEST(Tube, IsClosedAndHasTheVolumeOfAPrism) {
  // A straight tube with 20 corners: the area of a regular polygon times its length.
  const TriangleMesh straight = MakeTubeMesh({{1, 2, 3}, {1, 2, 3}, {4, 2, 3}, {11, 2, 3}}, 2);
  EXPECT_EQ(CountOpenEdges(straight), 0u);
  EXPECT_NEAR(CalcEnclosedVolume(straight), 10 * 10 * 4 * std::sin(2 * std::numbers::pi / 20), 1e-9);
  const TriangleMesh bent = MakeTubeMesh({{0, 0, 0}, {10, 0, 0}, {14, 6, 0}, {14, 12, 5}}, 1);
  EXPECT_EQ(CountOpenEdges(bent), 0u);
  EXPECT_GT(CalcEnclosedVolume(bent), 0);
  EXPECT_TRUE(MakeTubeMesh({{1, 1, 1}, {1, 1, 1}}, 1).triangles.empty());
  EXPECT_TRUE(MakeTubeMesh({}, 1).triangles.empty());
}

}  // namespace
}  // namespace kerf
