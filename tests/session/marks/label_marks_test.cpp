#include "session/marks/label_marks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>
#include <numbers>

#include "kerf/error.h"
#include "session/marks/segment.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::MessageOf;
using ::testing::HasSubstr;

/// A lattice with its labels.
struct Map {
  LabelLattice lattice;
  std::vector<std::int16_t> labels;

  Map(const std::array<int, 3>& size, const Vec3& origin_W, const std::array<Vec3, 3>& steps_W)
      : labels(static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
               static_cast<std::size_t>(size[2])) {
    lattice.size = size;
    lattice.origin_W = origin_W;
    lattice.steps_W = steps_W;
  }
  const LabelLattice& Get() {
    lattice.labels = labels;
    return lattice;
  }
  std::int16_t& At(int i, int j, int k) {
    return labels[static_cast<std::size_t>(i) +
                  static_cast<std::size_t>(lattice.size[0]) *
                      (static_cast<std::size_t>(j) +
                       static_cast<std::size_t>(lattice.size[1]) * static_cast<std::size_t>(k))];
  }
  /// Labels the voxels whose centres are at most `radius_mm` away from one of the points.
  void Paint(const std::vector<Vec3>& points_W, double radius_mm, std::int16_t label) {
    const auto& s = lattice.steps_W;
    for (const Vec3& p_W : points_W) {
      std::array<int, 3> low{};
      std::array<int, 3> high{};
      for (std::size_t a = 0; a < 3; ++a) {  // of orthogonal axes
        const double h = glm::length(s[a]);
        const double at = glm::dot(p_W - lattice.origin_W, s[a]) / (h * h);
        low[a] = static_cast<int>(std::floor(at - radius_mm / h));
        high[a] = static_cast<int>(std::ceil(at + radius_mm / h));
        ASSERT_GE(low[a], 0);
        ASSERT_LT(high[a], lattice.size[a]);
      }
      for (int k = low[2]; k <= high[2]; ++k) {
        for (int j = low[1]; j <= high[1]; ++j) {
          for (int i = low[0]; i <= high[0]; ++i) {
            const Vec3 q_W = lattice.origin_W + double(i) * s[0] + double(j) * s[1] + double(k) * s[2];
            if (glm::length(q_W - p_W) <= radius_mm) At(i, j, k) = label;
          }
        }
      }
    }
  }
};

Map MakeMap(const std::array<int, 3>& size, double voxel_mm, const Vec3& origin_W = Vec3(0)) {
  return {size, origin_W, {Vec3{voxel_mm, 0, 0}, Vec3{0, voxel_mm, 0}, Vec3{0, 0, voxel_mm}}};
}

/// Samples a curve so densely that the balls around its points make a smooth tube: between points 0.05 mm apart, a tube
/// of 1 mm is too thin by 0.3 um.
std::vector<Vec3> Sample(const std::function<Vec3(double)>& curve, double length_mm) {
  std::vector<Vec3> points;
  const int count = static_cast<int>(length_mm / 0.05);
  for (int i = 0; i <= count; ++i) points.push_back(curve(length_mm * i / count));
  return points;
}

/// `s`: length along the curve.
Vec3 Helix(double s) {
  constexpr double kRadius_mm = 9;
  constexpr double kRise = 0.4;  // mm per mm of length
  const double turn = s * std::sqrt(1 - kRise * kRise) / kRadius_mm;
  return {12 + kRadius_mm * std::cos(turn), 12 + kRadius_mm * std::sin(turn), 4 + kRise * s};
}
constexpr double kHelix_mm = 38;

Vec3 Arc(double s) {
  constexpr double kRadius_mm = 14;
  const double turn = 0.2 + s / kRadius_mm;
  return {4 + kRadius_mm * std::cos(turn), 4 + kRadius_mm * std::sin(turn), 5 + 0.1 * std::cos(turn)};
}
constexpr double kArc_mm = 16;

double CalcLength(const std::vector<Vec3>& line) {
  double length_mm = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length_mm += glm::length(line[i] - line[i - 1]);
  return length_mm;
}

/// Returns the largest distance of the points from the line.
double CalcDeviation(const std::vector<Vec3>& points, const std::vector<Vec3>& line) {
  double worst = 0;
  for (const Vec3& p : points) {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      best = std::min(best, CalcSegmentDistance(p, line[i], line[i + 1]));
    }
    worst = std::max(worst, best);
  }
  return worst;
}

/// The tolerances are those that label_marks.h states.
void ExpectTube(const Mark& mark, const std::vector<Vec3>& truth, double radius_mm, double voxel_mm) {
  const std::vector<Vec3> curve = CalcCurve(mark.points_W);
  ASSERT_GT(curve.size(), 1u);
  EXPECT_LT(CalcDeviation(curve, truth), 0.5 * voxel_mm);
  EXPECT_LT(CalcDeviation(truth, curve), 0.5 * voxel_mm);
  EXPECT_NEAR(mark.radius_mm, radius_mm, 0.05 * radius_mm);
  const double length_mm = CalcLength(truth);
  EXPECT_NEAR(CalcLength(curve), length_mm, 0.03 * length_mm);
  EXPECT_TRUE(LooksLikeNerve(mark));
}

TEST(LabelMarks, FollowATubeAlongAHelixOrAnArc) {
  for (const double h : {0.3, 0.5}) {
    for (const double r : {1.0, 1.5, 2.0}) {
      for (const bool is_helix : {true, false}) {
        SCOPED_TRACE(::testing::Message() << h << " mm, radius " << r << (is_helix ? ", helix" : ", arc"));
        const std::vector<Vec3> truth = is_helix ? Sample(Helix, kHelix_mm) : Sample(Arc, kArc_mm);
        const int n = static_cast<int>(24 / h);
        Map map = MakeMap({n, n, n}, h, {0.07, 0.11, 0.05});
        map.Paint(truth, r, 3);
        const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kNerve);
        ASSERT_EQ(marks.size(), 1u);
        EXPECT_EQ(marks[0].name, "nerve 1");
        ExpectTube(marks[0], truth, r, h);
        EXPECT_LT(marks[0].points_W.size(), 25u);  // thinned: there are up to 34 layers
      }
    }
  }
}

/// The truth is turned with the lattice, so each voxel has the same label as without.
TEST(LabelMarks, KeepTheLatticesFrame) {
  const glm::dmat3 turned = glm::mat3_cast(glm::normalize(Quat{0.8, 0.2, -0.5, 0.3}));
  const glm::dmat3 flipped{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  const double h = 0.5;
  const int n = 48;
  const std::vector<Vec3> straight = Sample(Helix, kHelix_mm);
  for (const glm::dmat3& R : {turned, flipped, turned * glm::dmat3{{1, 0, 0}, {0, -1, 0}, {0, 0, 1}}}) {
    const Vec3 origin_W(-40, 130, 7);
    Map map({n, n, n}, origin_W, {h * R[0], h * R[1], h * R[2]});
    std::vector<Vec3> truth;
    for (const Vec3& p : straight) truth.push_back(origin_W + R * p);
    map.Paint(truth, 1.5, 1);
    const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kCanal);
    ASSERT_EQ(marks.size(), 1u);
    EXPECT_EQ(marks[0].kind, MarkKind::kCanal);
    ExpectTube(marks[0], truth, 1.5, h);
  }
}

TEST(LabelMarks, FollowATubeInSlicesThatAreThick) {
  Map map({80, 80, 24}, Vec3(0), {Vec3{0.3, 0, 0}, Vec3{0, 0.3, 0}, Vec3{0, 0, 1}});
  const std::vector<Vec3> truth = Sample(Helix, kHelix_mm);
  map.Paint(truth, 1.5, 1);
  const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kNerve);
  ASSERT_EQ(marks.size(), 1u);
  ExpectTube(marks[0], truth, 1.5, 1);
}

TEST(LabelMarks, MakeABallOfABall) {
  for (const double r : {2.0, 4.0}) {
    Map map = MakeMap({40, 40, 40}, 0.3);
    const Vec3 centre(6.1, 5.9, 6.05);
    map.Paint({centre}, r, 7);
    const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kOther);
    ASSERT_EQ(marks.size(), 1u);
    ASSERT_EQ(marks[0].points_W.size(), 1u);
    // The error of a voxelised ball's volume is that of some dozens of its surface's voxels, up or down.
    EXPECT_NEAR(marks[0].radius_mm, r, 0.02 * r);
    EXPECT_LT(glm::length(marks[0].points_W[0] - centre), 0.1);
    EXPECT_FALSE(LooksLikeNerve(marks[0]));
  }
}

/// A tooth is longer than wide, but not a nerve.
TEST(LabelMarks, MakeACurveOfATooth) {
  Map map = MakeMap({60, 60, 80}, 0.4);
  const std::vector<Vec3> truth = Sample([](double s) { return Vec3{12, 12, 7 + s}; }, 15);
  map.Paint(truth, 3.5, 1);
  const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kTooth);
  ASSERT_EQ(marks.size(), 1u);
  EXPECT_EQ(marks[0].name, "tooth 1");
  EXPECT_NEAR(CalcLength(marks[0].points_W), 15, 0.45);
  EXPECT_NEAR(marks[0].radius_mm, 3.5, 0.05 * 3.5);
  EXPECT_FALSE(LooksLikeNerve(marks[0]));
}

TEST(LabelMarks, SeparateLabelsThatTouchAndPartsThatDoNot) {
  const double h = 0.5;
  Map map = MakeMap({60, 40, 30}, h);
  const auto line = [](double y) { return Sample([y](double s) { return Vec3{4 + s, y, 7}; }, 18); };
  map.Paint(line(5), 1.5, 2);
  map.Paint(line(8), 1.5, 1);     // touches the first
  map.Paint(line(14.5), 1.5, 2);  // apart from it
  const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kNerve);
  ASSERT_EQ(marks.size(), 3u);
  std::vector<double> y_mm;
  for (const Mark& mark : marks) {
    EXPECT_NEAR(mark.radius_mm, 1.5, 0.075);
    y_mm.push_back(mark.points_W.front().y);
  }
  EXPECT_NEAR(y_mm[0], 8, 0.1);  // in the order of the labels
  EXPECT_NEAR(std::min(y_mm[1], y_mm[2]), 5, 0.1);
  EXPECT_NEAR(std::max(y_mm[1], y_mm[2]), 14.5, 0.1);
  EXPECT_EQ(marks[2].name, "nerve 3");
}

TEST(LabelMarks, JoinVoxelsByTheirCorners) {
  Map map = MakeMap({20, 20, 20}, 1);
  for (int i = 2; i < 18; ++i) map.At(i, i, i) = 1;
  const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kNerve);
  ASSERT_EQ(marks.size(), 1u);
  // 16 voxels, sqrt(3) mm apart; the curve ends less than a radius and a voxel before the last ones.
  EXPECT_NEAR(CalcLength(marks[0].points_W), 15 * std::sqrt(3.0), 2);
}

TEST(LabelMarks, KeepTheLargestOnly) {
  Map map = MakeMap({40, 12, 12}, 1);
  for (int i = 0; i < 5; ++i) map.Paint({{4.0 + 7 * i, 6, 6}}, 1.2 + 0.4 * i, 1);
  map.At(0, 0, 0) = 1;  // 1 mm3, which is enough
  std::size_t left_out = 0;
  EXPECT_EQ(MakeMarksFromLabels(map.Get(), MarkKind::kTooth, 100, &left_out).size(), 6u);
  EXPECT_EQ(left_out, 0u);
  const std::vector<Mark> marks = MakeMarksFromLabels(map.Get(), MarkKind::kTooth, 2, &left_out);
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(left_out, 4u);
  EXPECT_NEAR(marks[0].points_W[0].x, 32, 0.1);
  EXPECT_NEAR(marks[1].points_W[0].x, 25, 0.1);
}

TEST(LabelMarks, RefuseAMapWithoutStructures) {
  Map map = MakeMap({10, 10, 10}, 0.5);
  map.At(4, 4, 4) = 1;  // 0.125 mm3
  EXPECT_THAT(MessageOf([&] { MakeMarksFromLabels(map.Get(), MarkKind::kNerve); }),
              HasSubstr("no structure of at least 1"));
  map.labels.pop_back();
  EXPECT_THAT(MessageOf([&] { MakeMarksFromLabels(map.Get(), MarkKind::kNerve); }), HasSubstr("999 labels for 1000"));
}

}  // namespace
}  // namespace kerf
