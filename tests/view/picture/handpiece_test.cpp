#include "view/picture/handpiece.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <optional>
#include <vector>

#include "cut/tool/looks.h"
#include "cut/tool/planar_blade.h"
#include "cut/tool/shape.h"
#include "kerf/error.h"

namespace kerf {
namespace {

std::vector<Tool> MakeTools() {
  DiscSaw thin;
  DiscSaw large;
  large.diameter_mm = 70;
  large.thickness_mm = 1.2;
  DiscSaw aslant;
  aslant.p_TG_mm = {30, -20, 70};
  DiscSaw beside;
  beside.p_TG_mm = {60, 0, -10};
  return {
      thin, large, aslant, beside, BallBurr{}, BallBurr{.diameter_mm = 1}, FissureBur{}, FissureBur{.diameter_mm = 6}};
}

TEST(Handpiece, IsAClosedSolidOnTheSideOfTheSpindle) {
  for (const Tool& tool : MakeTools()) {
    const TriangleMesh mesh = MakeHandpieceMesh(tool);
    EXPECT_EQ(CountOpenEdges(mesh), 0u);
    EXPECT_GT(CalcEnclosedVolume(mesh), 100);
    double clear = IsBlade(tool) ? 0.4 * CalcReach(tool) : 1.4 * CalcReach(tool);
    // A bur's neck begins a little above its head.
    if (const std::optional<RoundSolid> solid = CalcRoundSolid(tool)) {
      clear = solid->top_z_mm + 4;
      const auto lowest = std::min_element(mesh.points.begin(), mesh.points.end(),
                                           [](const Vec3& a, const Vec3& b) { return a.z < b.z; });
      EXPECT_LT(lowest->z, solid->top_z_mm + 6);
    }
    for (const Vec3& p : mesh.points) {
      EXPECT_GT(p.z, clear);  // nothing near the cut
      EXPECT_LT(glm::length(p), CalcHandpieceReach(tool));
    }
  }
}

TEST(Handpiece, IsBehindABladeWithAStroke) {
  const ReciprocatingBlade blade;
  const TriangleMesh mesh = MakeHandpieceMesh(blade);
  EXPECT_EQ(CountOpenEdges(mesh), 0u);
  EXPECT_GT(CalcEnclosedVolume(mesh), 100);
  double furthest = 0;
  for (const Vec3& p : mesh.points) {
    EXPECT_LT(p.y, -0.5 * (blade.length_mm + blade.stroke_mm) + 1e-9);  // the blade does not move into it
    EXPECT_LT(glm::length(p), CalcHandpieceReach(blade));
    furthest = std::min(furthest, p.y);
  }
  EXPECT_LT(furthest, blade.p_TG_mm.y);
}

TEST(Handpiece, IsAtTheBackOfABladeWithoutATip) {
  for (const Tool& tool : {Tool(OscillatingBlade{}), Tool(PiezoInsert{})}) {
    const PlanarBlade blade = *FindPlanarBlade(tool);
    const TriangleMesh mesh = MakeHandpieceMesh(tool);
    EXPECT_EQ(CountOpenEdges(mesh), 0u);
    double furthest = 0;
    for (const Vec3& p : mesh.points) {
      EXPECT_LT(p.x, -blade.length_mm() + 1e-9);
      EXPECT_LT(glm::length(p), CalcHandpieceReach(tool));
      furthest = std::min(furthest, p.x);
    }
    EXPECT_LT(furthest, CalcGrip(tool).x);
  }
}

TEST(Handpiece, LeadsThroughTheGrip) {
  DiscSaw saw;
  saw.p_TG_mm = {30, -20, 70};
  // By Gauss's theorem, the solid angle of a closed surface about a point inside is 4 pi, and 0 outside.
  const TriangleMesh mesh = MakeHandpieceMesh(saw);
  const auto solid_angle = [&](const Vec3& q) {
    double sum = 0;
    for (const auto& t : mesh.triangles) {
      const Vec3 a = mesh.points[t[0]] - q;
      const Vec3 b = mesh.points[t[1]] - q;
      const Vec3 c = mesh.points[t[2]] - q;
      const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
      sum += 2 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
    }
    return sum;
  };
  EXPECT_NEAR(solid_angle(saw.p_TG_mm), 4 * std::numbers::pi, 1e-6);
  EXPECT_NEAR(solid_angle({0, 0, 0}), 0, 1e-6);
}

TEST(Handpiece, SamplesLieOnItsWholeLength) {
  const DiscSaw saw;
  const TriangleMesh mesh = MakeHandpieceMesh(saw);
  const auto height = [](const Vec3& p) { return p.z; };
  std::vector<double> at_mm;
  for (const Vec3& p : SampleHandpiece(saw, 4)) at_mm.push_back(height(p));
  std::sort(at_mm.begin(), at_mm.end());
  const auto by_height = [&](const Vec3& a, const Vec3& b) { return height(a) < height(b); };
  const auto [low, high] = std::minmax_element(mesh.points.begin(), mesh.points.end(), by_height);
  EXPECT_EQ(at_mm.front(), height(*low));
  EXPECT_EQ(at_mm.back(), height(*high));
  for (std::size_t i = 1; i < at_mm.size(); ++i) EXPECT_LE(at_mm[i] - at_mm[i - 1], 4 + 1e-9);
}

TEST(Guard, CoversTheRimOnOneSideOnly) {
  for (const double diameter : {8.0, 22.0, 70.0}) {
    DiscSaw saw;
    saw.diameter_mm = diameter;
    const TriangleMesh mesh = MakeToolLooks(saw).guard;
    EXPECT_EQ(CountOpenEdges(mesh), 0u);
    EXPECT_GT(CalcEnclosedVolume(mesh), 0);
    for (const Vec3& p : mesh.points) {
      // Within 55 degrees of the x axis, and outside the disc's body.
      EXPECT_LT(std::abs(std::atan2(p.y, p.x)), 55.001 * std::numbers::pi / 180);
      const bool in_disc = std::hypot(p.x, p.y) < saw.radius_mm() && std::abs(p.z) < 0.5 * saw.thickness_mm;
      EXPECT_FALSE(in_disc);
    }
  }
  DiscSaw invalid;
  invalid.diameter_mm = -1;
  EXPECT_THROW(MakeToolLooks(invalid), Error);
  EXPECT_THROW(MakeHandpieceMesh(invalid), Error);
}

}  // namespace
}  // namespace kerf
