#include "session/plan/section_line.h"

#include <gtest/gtest.h>

#include <array>
#include <glm/geometric.hpp>
#include <numbers>

#include "perfect_cut.h"
#include "session/plan/edit_plane.h"

namespace kerf {
namespace {

double CalcLength(const std::vector<Vec3>& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += glm::length(line[i] - line[i - 1]);
  return length;
}

/// Signed area around the normal: positive if counter-clockwise.
double CalcArea(const std::vector<Vec3>& line, const Vec3& normal) {
  Vec3 sum(0);
  for (std::size_t i = 1; i < line.size(); ++i) sum += glm::cross(line[i - 1] - line[0], line[i] - line[0]);
  return 0.5 * glm::dot(sum, normal);
}

TEST(SectionLine, OfASphereIsACircle) {
  constexpr double kVoxel_mm = 0.25;
  constexpr double kRadius_mm = 6;
  const Vec3 centre(1, -2, 3);
  const Bone ball = test::MakeSphere(centre, kRadius_mm, kVoxel_mm);
  const PhiSampler phi(ball);
  plan_test::Draw draw(21);
  for (int i = 0; i < 20; ++i) {
    const Vec3 normal = draw.Direction();
    const double off = draw.In(-4.5, 4.5);
    const PlannedPlane plane{.name = "p",
                             .plane = {centre + off * normal, normal},
                             .width_mm = 20,
                             .height_mm = 20,
                             .up_W = draw.Direction()};
    const auto lines = SectionLine(phi, plane);
    ASSERT_EQ(lines.size(), 1u);
    EXPECT_EQ(lines[0].front(), lines[0].back());
    const double r = std::sqrt(kRadius_mm * kRadius_mm - off * off);
    for (const Vec3& p : lines[0]) {
      EXPECT_NEAR(glm::dot(p - plane.plane.p_W, normal), 0, 1e-12);
      // Interpolation of a distance with curvature 1 / radius over a voxel: at most h^2 / (8 r) in each of three
      // directions of the trilinear interpolation and two of the lattice.
      EXPECT_NEAR(glm::length(p - centre), kRadius_mm, 5 * kVoxel_mm * kVoxel_mm / (8 * kRadius_mm));
    }
    EXPECT_NEAR(CalcArea(lines[0], normal), std::numbers::pi * r * r, 0.01 * r * r);
    EXPECT_NEAR(CalcLength(lines[0]), 2 * std::numbers::pi * r, 0.01 * r);
  }
}

TEST(SectionLine, OfABlockIsARectangleAndEndsAtTheBorder) {
  constexpr double kVoxel_mm = 0.2;
  plan_test::Draw draw(22);
  for (int i = 0; i < 5; ++i) {
    const Pose X_WB = draw.AnyPose();
    const Bone block = test::MakeBox(X_WB, {10, 6, 4}, kVoxel_mm);
    const PhiSampler phi(block);
    PlannedPlane plane{.name = "p",
                       .plane = {X_WB.p_AB, X_WB.Vector({1, 0, 0})},
                       .width_mm = 30,
                       .height_mm = 30,
                       .up_W = X_WB.Vector({0, 0, 1})};
    const auto whole = SectionLine(phi, plane);
    ASSERT_EQ(whole.size(), 1u);
    // Edges of the block are rounded at the scale of a voxel: each corner loses less than a voxel of length.
    EXPECT_NEAR(CalcLength(whole[0]), 20, 4 * kVoxel_mm);
    EXPECT_NEAR(CalcArea(whole[0], plane.plane.normal_W), 24, 4 * kVoxel_mm * kVoxel_mm);
    // The rectangle covers only the middle 2 mm of the width: two lines across it, without ends of the block.
    plane.width_mm = 2;
    const auto cut_off = SectionLine(phi, plane);
    ASSERT_EQ(cut_off.size(), 2u);
    for (const auto& line : cut_off) {
      EXPECT_NEAR(CalcLength(line), 2, 1e-3);
      EXPECT_NE(line.front(), line.back());
    }
    plane.plane.p_W += 6.0 * plane.plane.normal_W;
    EXPECT_TRUE(SectionLine(phi, plane).empty());
  }
}

TEST(SectionLine, SeparatesTheLinesOfTwoParts) {
  Bone block = test::MakeBox({}, {12, 6, 4}, 0.2);
  plan_test::CutKerf(block, {{0, 0, 0}, {1, 0, 0}}, 1.0);
  const PlannedPlane plane{
      .name = "p", .plane = {{0, 0, 0}, {0, 0, 1}}, .width_mm = 30, .height_mm = 30, .up_W = {0, 1, 0}};
  const auto lines = SectionLine(PhiSampler(block), plane);
  ASSERT_EQ(lines.size(), 2u);
  for (const auto& line : lines) EXPECT_NEAR(CalcArea(line, {0, 0, 1}), 5.5 * 6, 4 * 0.2 * 0.2);
}

TEST(FitToSection, EnclosesThePartNearThePoints) {
  // Two bars along x, 20 x 6 x 10 mm, whose middles lie 16 mm apart along y; the first has a cavity along x.
  constexpr double kVoxel_mm = 0.25;
  SolidField field;
  field.value = [](const Vec3& p) {
    const double cavity = 2 - std::hypot(p.y, p.z);
    return std::min(std::max(test::BoxDistance(p, {10, 3, 5}), cavity),
                    test::BoxDistance(p - Vec3(0, 16, 0), {10, 3, 5}));
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Box3 box{{-10, -3, -5}, {10, 19, 5}};
  const Bone bone = MakeBone(field, box.Grown(6 * kVoxel_mm), {kVoxel_mm, kVoxel_mm, {}}, test::OneRegionTable());
  const PhiSampler phi(bone);
  // The plane x = 2, whose across axis is y.
  const PlannedPlane plane{.name = "p", .plane = {{2, 1, 2}, {1, 0, 0}}, .width_mm = 50, .height_mm = 50};
  const auto check = [&](const PlannedPlane& fitted, double y, double width) {
    // The lattice reaches 240 mm with at most 1024 steps of 0.23 mm. Lines end up to half a step from an edge of the
    // bar.
    EXPECT_NEAR(fitted.plane.p_W.x, 2, 1e-9);
    EXPECT_NEAR(fitted.plane.p_W.y, y, 0.15);
    EXPECT_NEAR(fitted.plane.p_W.z, 0, 0.15);
    EXPECT_EQ(fitted.plane.normal_W, plane.plane.normal_W);
    EXPECT_NEAR(fitted.width_mm, width + 8, 0.3);
    EXPECT_NEAR(fitted.height_mm, 10 + 8, 0.3);
  };
  check(FitToSection(phi, plane, std::array{Vec3(2, -3, 0)}), 0, 6);
  check(FitToSection(phi, plane, std::array{Vec3(2, 1.9, 0)}), 0, 6);  // at the cavity
  check(FitToSection(phi, plane, std::array{Vec3(2, 20, 1)}), 16, 6);
  check(FitToSection(phi, plane, std::array{Vec3(2, -3, 0), Vec3(2, 20, 1)}), 8, 22);
  // A plane that meets no bone stays as it is.
  PlannedPlane beside = plane;
  beside.plane.p_W.x = 40;
  EXPECT_EQ(FitToSection(phi, beside, std::array{Vec3(40, 0, 0)}).plane.p_W, beside.plane.p_W);
  EXPECT_EQ(FitToSection(phi, beside, std::array{Vec3(40, 0, 0)}).width_mm, 50);
}

}  // namespace
}  // namespace kerf
