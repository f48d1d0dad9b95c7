// A tool represented by points: they lie on its surface and represent its number of teeth, for any sampling.
#include "cut/tool/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <map>
#include <numbers>
#include <random>

#include "cut/tool/looks.h"
#include "cut/tool/planar_blade.h"
#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

double SumTeeth(const ToolShape& shape) {
  double sum = 0;
  for (const EdgePoint& p : shape.edge) sum += p.teeth;
  return sum;
}

TEST(ToolShape, DiscHasItsTeethEvenlyOnItsRim) {
  const DiscSaw disc;
  for (const int samples : {1, 3, 8, 256}) {
    const ToolShape shape = MakeToolShape(disc, {samples, 1, 0.15, 0.1});
    EXPECT_EQ(shape.edge_form, EdgeForm::kRing);
    EXPECT_EQ(shape.passes_per_turn, 24);
    EXPECT_NEAR(SumTeeth(shape), 24, 1e-9);  // rounding error of the sum
    Vec3 sum(0);
    for (std::size_t i = 0; i < shape.edge.size(); ++i) {
      const EdgePoint& p = shape.edge[i];
      const EdgePoint& next = shape.edge[(i + 1) % shape.edge.size()];
      EXPECT_NEAR(glm::length(p.p_T - 11.0 * p.e_T), 0, 1e-12);
      EXPECT_NEAR(glm::length(next.p_T - p.p_T),
                  22 * std::sin(std::numbers::pi / static_cast<double>(shape.edge.size())), 1e-9);
      sum += p.e_T;
    }
    EXPECT_NEAR(glm::length(sum), 0, 1e-9);
  }
}

TEST(ToolShape, FacesOfTheDiscLieOnBothFlatsWithinTheMarginAndTheRequestedSpacing) {
  const DiscSaw disc;
  const double spacing = 0.9;
  const ToolShape shape = MakeToolShape(disc, {8, spacing, 0.3, 0.3});
  double outermost = 0;
  int above = 0;
  for (const FacePoint& p : shape.faces) {
    EXPECT_NEAR(p.p_T.z, 0.125 * p.n_T.z, 1e-15);
    EXPECT_EQ(std::abs(p.n_T.z), 1);
    outermost = std::max(outermost, std::hypot(p.p_T.x, p.p_T.y));
    above += p.n_T.z > 0 ? 1 : 0;
    double nearest = 100;
    for (const FacePoint& q : shape.faces) {
      if (&q != &p && q.n_T.z == p.n_T.z) nearest = std::min(nearest, glm::length(q.p_T - p.p_T));
    }
    // The next ring is half a spacing away, and a point on it at most a full spacing along it; rings near the spindle
    // are short.
    EXPECT_LE(nearest, 1.2 * spacing);
  }
  EXPECT_NEAR(outermost, 10.7, 1e-9);
  EXPECT_EQ(2 * static_cast<std::size_t>(above), shape.faces.size());
}

TEST(ToolShape, FacesInTheCuttingRimAreForAStoppedSpindle) {
  const ToolShape shape = MakeToolShape(DiscSaw{}, {8, 0.9, 0.3, 0.15});
  int stopped = 0;
  for (const FacePoint& p : shape.faces) {
    EXPECT_EQ(p.touching == Touching::kStopped, std::hypot(p.p_T.x, p.p_T.y) > 10.7 + 1e-9);
    stopped += p.touching == Touching::kStopped ? 1 : 0;
  }
  EXPECT_GT(stopped, 100);  // both sides of a ring of 68 mm, every 0.9 mm
}

TEST(ToolShape, BallHasFlutesTimesTheirLengthOfEdge) {
  // Each flute is half a great circle, pi r long.
  BallBurr ball;
  ball.flutes = 10;
  ball.tooth_width_mm = 0.25;
  for (const int samples : {4, 8, 16, 64}) {
    const ToolShape shape = MakeToolShape(ball, {samples, 1, 0, 0});
    EXPECT_NEAR(SumTeeth(shape), 10 * std::numbers::pi * 3 / 0.25, 1e-6);
    EXPECT_TRUE(shape.faces.empty());
    for (const EdgePoint& p : shape.edge) EXPECT_NEAR(glm::length(p.p_T - 3.0 * p.e_T), 0, 1e-12);
  }
}

TEST(ToolShape, MeanTeethAcrossTheFeedOfABallConvergeToTheirIntegral) {
  // The sum of the teeth times max(0, cos) for a feed along x is flutes r / (2 pi w) * int dtheta dphi max(0, sin theta
  // cos phi) = flutes r / (2 pi w) * 2 * 2 = 2 flutes r / (pi w).
  const BallBurr ball;
  const double exact = 2 * ball.flutes * ball.radius_mm() / (std::numbers::pi * ball.tooth_width_mm);
  double error[2];
  for (int i = 0; i < 2; ++i) {
    const ToolShape shape = MakeToolShape(ball, {i == 0 ? 16 : 64, 1, 0, 0});
    double sum = 0;
    for (const EdgePoint& p : shape.edge) sum += p.teeth * std::max(0.0, p.e_T.x);
    error[i] = std::abs(sum / exact - 1);
  }
  EXPECT_LT(error[0], 0.005);         // midpoint rule, 16 x 32 points
  EXPECT_LT(error[1], error[0] / 8);  // exact second order would give 1/16
}

TEST(ToolShape, BurHasFlutesTimesTheLengthOfItsProfile) {
  FissureBur bur;
  bur.point_angle_deg = 90;
  bur.taper = 0.7;
  bur.tooth_width_mm = 0.25;
  const RoundSolid solid = *CalcRoundSolid(bur);
  // A point of 90 degrees is as high as its radius.
  EXPECT_NEAR(solid.corner_z_mm, solid.corner_radius_mm, 1e-12);
  EXPECT_NEAR(solid.corner_radius_mm, 0.7 * 0.8, 1e-12);
  const double profile_mm = std::hypot(solid.corner_radius_mm, solid.corner_z_mm) +
                            std::hypot(0.8 - solid.corner_radius_mm, 8 - solid.corner_z_mm);
  for (const int samples : {4, 16, 64}) {
    const ToolShape shape = MakeToolShape(bur, {samples, 1, 0, 0});
    EXPECT_NEAR(SumTeeth(shape), 6 * profile_mm / 0.25, 1e-6);
    for (const EdgePoint& p : shape.edge) {
      // The outward direction is the gradient of the distance.
      EXPECT_NEAR(CalcSignedToolDistance(bur, p.p_T + 1e-3 * p.e_T), 1e-3, 1e-9);
    }
  }
}

// Properties that hold for every kind of tool, whatever its shape.

TEST(ToolKinds, NearestPointLiesOnTheBodyAtTheDistance) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> at(-1.5, 1.5);
  for (const Tool& tool : GetDefaultTools()) {
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p_T = CalcReach(tool) * Vec3(at(random), at(random), at(random));
      const double distance_mm = CalcSignedToolDistance(tool, p_T);
      const Vec3 nearest_T = FindNearestOfTool(tool, p_T);
      EXPECT_NEAR(CalcToolDistance(tool, nearest_T), 0, 1e-12) << GetShape(tool);
      EXPECT_NEAR(glm::length(p_T - nearest_T), std::max(0.0, distance_mm), 1e-12) << GetShape(tool);
      EXPECT_EQ(CalcToolDistance(tool, p_T), std::max(0.0, distance_mm));
    }
  }
}

TEST(ToolKinds, PassedDistanceIsTheLeastOfAllDisplacements) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> at(-1.5, 1.5);
  const ReciprocatingBlade blade{.length_mm = 10, .taper = 0.5, .set_mm = 0, .stroke_mm = 4};
  for (int i = 0; i < 300; ++i) {
    const Vec3 p_T = CalcReach(blade) * Vec3(at(random), at(random), at(random));
    double least_mm = 1e300;
    for (int k = -200; k <= 200; ++k) {
      least_mm = std::min(least_mm, CalcToolDistance(blade, p_T - Vec3(0, 0.01 * k, 0)));
    }
    EXPECT_NEAR(CalcPassedDistance(blade, p_T), least_mm, 1e-3);
    EXPECT_EQ(CalcPassedDistance(DiscSaw{}, p_T), CalcToolDistance(DiscSaw{}, p_T));
  }
}

TEST(ToolKinds, DeepestPointIsTheFurthestOfTheEdge) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> at(-1, 1);
  for (const Tool& tool : GetDefaultTools()) {
    const ToolShape shape = MakeToolShape(tool, {64, 1, 0, 0});
    for (int i = 0; i < 50; ++i) {
      const Vec3 n_T = glm::normalize(Vec3(at(random), at(random), at(random)));
      double furthest_mm = -1e9;
      for (const EdgePoint& p : shape.edge) furthest_mm = std::max(furthest_mm, glm::dot(n_T, p.p_T));
      const double deepest_mm = glm::dot(n_T, FindDeepest(tool, n_T));
      EXPECT_GE(deepest_mm, furthest_mm - 1e-12) << GetShape(tool);
      // The samples of a ball with 64 x 128 points are up to 1.8 degrees off: 1 - cos(1.8 deg) = 0.0005. The rings of a
      // bur are at most two 128ths of its circumference apart, and the outermost lies half of that from its edge.
      const double ring_mm = GetForm(tool) == ToolForm::kRound ? 2 * std::numbers::pi * CalcRadius(tool) / 128 : 0;
      EXPECT_LE(deepest_mm, furthest_mm + 0.0005 * CalcRadius(tool) + ring_mm) << GetShape(tool);
    }
    EXPECT_EQ(FindDeepest(tool, Vec3(0)), Vec3(0));
  }
}

TEST(ToolKinds, MeasuresAgreeWithTheShape) {
  for (const Tool& tool : GetDefaultTools()) {
    const ToolShape shape = MakeToolShape(tool, {16, 1, 0, 0});
    double radius_mm = 0, reach_mm = 0;
    for (const EdgePoint& p : shape.edge) {
      radius_mm = std::max(radius_mm, std::hypot(p.p_T.x, p.p_T.y));
      reach_mm = std::max(reach_mm, glm::length(p.p_T));
      EXPECT_NEAR(CalcSignedToolDistance(tool, p.p_T), 0, 1e-12) << GetShape(tool);
    }
    // A ball has no sample on its equator, and a drill none on the outer end of its lips: those of the default drill
    // are sampled in six parts.
    EXPECT_LE(radius_mm, CalcRadius(tool) * (1 + 1e-12));
    EXPECT_GT(radius_mm, (shape.faces.empty() || IsBlade(tool) ? 0.99 : 0.9) * CalcRadius(tool));
    EXPECT_LE(reach_mm, CalcReach(tool) + 1e-12);
    EXPECT_EQ(shape.passes_per_turn, CountPassesPerTurn(tool));
    EXPECT_EQ(shape.reach_mm, CalcReach(tool));
    EXPECT_EQ(CalcThickness(tool) > 0, IsBlade(tool));
    EXPECT_LE(CalcThickness(tool), CalcCutWidth(tool));  // the teeth may be set
    // The faces are in pairs on opposite sides, with the gradient of the distance as their normal.
    ASSERT_EQ(shape.faces.size() % 2, 0u);
    for (std::size_t i = 0; i < shape.faces.size(); ++i) {
      const FacePoint& p = shape.faces[i];
      EXPECT_NEAR(CalcSignedToolDistance(tool, p.p_T), 0, 1e-12) << GetShape(tool);
      EXPECT_NEAR(CalcSignedToolDistance(tool, p.p_T + 0.01 * p.n_T), 0.01, 1e-12) << GetShape(tool);
      EXPECT_EQ(p.n_T, -shape.faces[i ^ 1].n_T);
    }
  }
}

TEST(ToolKinds, LooksAreClosedAndSamplesCoverTheBody) {
  for (const Tool& tool : GetDefaultTools()) {
    const ToolLooks looks = MakeToolLooks(tool);
    for (const TriangleMesh* mesh : {&looks.whole, &looks.turning, &looks.guard}) {
      std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;  // +1 in one direction, -1 in the other
      for (const auto& t : mesh->triangles) {
        for (std::size_t i = 0; i < 3; ++i) {
          const std::uint32_t a = t[i], b = t[(i + 1) % 3];
          edges[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        }
      }
      for (const auto& [edge, sum] : edges) ASSERT_EQ(sum, 0) << GetShape(tool);
    }
    EXPECT_FALSE(looks.whole.triangles.empty());
    for (const Vec3& p_T : looks.outline) EXPECT_NEAR(CalcSignedToolDistance(tool, p_T), 0, 1e-9);
    // Each point of the surface lies within a step of a sample, and no sample lies outside.
    constexpr double kStep_mm = 0.5;
    const std::vector<Vec3> samples = SampleToolSurface(tool, kStep_mm);
    for (const Vec3& p_T : samples) ASSERT_LT(CalcSignedToolDistance(tool, p_T), 1e-9);
    const double outermost_mm = glm::length(samples.front()) + 0.5 * CalcThickness(tool);
    for (const Vec3& p_T : samples) ASSERT_LE(glm::length(p_T), outermost_mm + 1e-9);
    for (const EdgePoint& point : MakeToolShape(tool, {}).edge) {
      double nearest_mm = 1e9;
      for (const Vec3& p_T : samples) nearest_mm = std::min(nearest_mm, glm::distance(p_T, point.p_T));
      EXPECT_LT(nearest_mm, kStep_mm) << GetShape(tool);
    }
  }
}

TEST(ToolKinds, SectionLiesInThePlaneAndOnTheSurface) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> number(-1, 1);
  for (const Tool& tool : GetDefaultTools()) {
    int met = 0;
    for (int n = 0; n < 400; ++n) {  // a drill is thin
      const double reach_mm = CalcReach(tool);
      const Vec3 axis = glm::normalize(Vec3(number(random), number(random), number(random)));
      const Pose X_ST{glm::angleAxis(3 * number(random), axis),
                      1.2 * reach_mm * Vec3(number(random), number(random), number(random))};
      const std::vector<Vec3> outline = MakeToolSection(tool, X_ST, 0);
      if (outline.empty()) continue;
      ++met;
      EXPECT_LT(glm::distance(outline.front(), outline.back()), 1e-9);
      const Pose X_TS = X_ST.Inverse();
      for (const Vec3& p_S : outline) {
        EXPECT_NEAR(p_S.z, 0, 1e-9);
        // An arc is drawn as chords.
        const double sagitta_mm = CalcSwingRadius(tool) > 0 ? FindPlanarBlade(tool)->CalcSagitta() : 0;
        EXPECT_NEAR(CalcSignedToolDistance(tool, X_TS.Point(p_S)), 0, 1e-6 * reach_mm + sagitta_mm)
            << GetShape(tool) << n;
      }
    }
    EXPECT_GT(met, 50);
  }
}

TEST(ToolKinds, BladesWithAStrokeSweepTheirDisplacements) {
  // Against points of the blade at many displacements: none lies outside of the hull by more than the arc's sagitta,
  // and the hull reaches no further than the furthest of them, but for the bulge of the back about the swing axis.
  std::mt19937 random(6);
  std::uniform_real_distribution<double> number(0, 1);
  for (const Tool& tool : GetDefaultTools()) {
    const auto blade = FindPlanarBlade(tool);
    EXPECT_EQ(blade.has_value(), GetDrive(tool) == DriveMotion::kStroke);
    if (!blade) continue;
    EXPECT_LE(blade->CalcSagitta(), 0.01);
    for (int n = 0; n < 40; ++n) {
      const double a = blade->stroke_mm * (number(random) - 0.5), b = blade->stroke_mm * (number(random) - 0.5);
      const SlideRange slide{std::min(a, b), std::max(a, b)};
      const ConvexOutline swept = blade->SweepOutline(slide);
      const double rad = 2 * std::numbers::pi * n / 40;
      double hull_mm = -1e9, furthest_mm = -1e9;
      for (int i = 0; i < swept.size(); ++i) {
        hull_mm = std::max(hull_mm, std::cos(rad) * swept.corner(i).x + std::sin(rad) * swept.corner(i).y);
      }
      for (int k = 0; k <= 50; ++k) {
        const double slide_mm = slide.least_mm + slide.size_mm() * k / 50;
        std::vector<Vec3> points{{blade->back_low.x, blade->back_low.y, 0},
                                 {blade->back_high.x, blade->back_high.y, 0}};
        for (int i = 0; i <= 80; ++i) {
          points.push_back(blade->motion().Move(Vec3(0), blade->edge_mm * (i / 80.0 - 0.5)));
        }
        for (const Vec3& p : points) {
          const Vec3 moved = blade->motion().Move(p, slide_mm);
          EXPECT_LE(swept.CalcSignedDistance({moved.x, moved.y}), blade->CalcSagitta() + 1e-12) << GetShape(tool);
          furthest_mm = std::max(furthest_mm, std::cos(rad) * moved.x + std::sin(rad) * moved.y);
        }
      }
      EXPECT_NEAR(hull_mm, furthest_mm, blade->CalcSagitta() + 1e-3) << GetShape(tool);
    }
  }
}

TEST(ConvexOutline, HullOfPointsOnALineButForRoundingLosesNoCorner) {
  // A blade that rests at an oblique pose: each corner twice, which differ by rounding in any direction.
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int n = 0; n < 500; ++n) {
    std::vector<ConvexOutline::Point> points;
    for (const ConvexOutline::Point& p : {ConvexOutline::Point{0, -2.6},
                                          {0, -2.57},
                                          {0, 2.78},
                                          {0, 2.81},
                                          {-7.1, -2.4},
                                          {-7.1, -2.3},
                                          {-7.1, 2.5},
                                          {-7.1, 2.6}}) {
      points.push_back(p);
      points.push_back({p.x + 4e-16 * std::round(4 * number(random)), p.y + 4e-16 * std::round(4 * number(random))});
    }
    const ConvexOutline hull = ConvexOutline::MakeHull(points, {});
    double area_mm2 = 0;
    for (int i = 0; i < hull.size(); ++i) {
      const ConvexOutline::Point &a = hull.corner(i), &b = hull.corner((i + 1) % hull.size());
      EXPECT_GT(std::hypot(a.x - b.x, a.y - b.y), 0.01);  // a side as short as rounding has no direction
      area_mm2 += 0.5 * (a.x * b.y - b.x * a.y);
    }
    EXPECT_NEAR(area_mm2, 0.5 * 7.1 * (5.41 + 5), 1e-9) << n;
  }
}

TEST(ToolKinds, ASwingMovesPointsAboutItsAxis) {
  const EdgeMotion motion(25);
  const Vec3 p_T(-3, 4, 0.2), axis_T(-25, 0, 0.2);
  const double rad = 0.03, dt = 1e-6;
  const Vec3 moved = motion.Move(p_T, 25 * rad);
  EXPECT_NEAR(glm::distance(moved, axis_T), glm::distance(p_T, axis_T), 1e-12);
  EXPECT_NEAR(std::atan2(moved.y, moved.x + 25) - std::atan2(4, 22), rad, 1e-12);
  // The edge's own middle moves by the displacement, and a point's velocity is the derivative of its place.
  EXPECT_NEAR(motion.Move(Vec3(0), 25 * rad).y, 25 * std::sin(rad), 1e-12);
  const Vec3 v = (motion.Move(p_T, 25 * rad + 100 * dt) - moved) / dt;
  EXPECT_NEAR(glm::distance(motion.CalcVelocity(moved, 100), v), 0, 1e-3);
  // The pose of the edge's frame takes its points to the same places.
  const Pose X_WT{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, 3))), {4, 5, 6}};
  EXPECT_NEAR(glm::distance(motion.Move(X_WT, 25 * rad).Point(p_T), X_WT.Point(moved)), 0, 1e-12);
}

TEST(ToolKinds, ShapesHaveTheirWords) {
  EXPECT_EQ(GetToolShapes(),
            (std::vector<std::string_view>{"disc", "ball", "bur", "drill", "reciprocating", "oscillating", "piezo"}));
  EXPECT_EQ(
      DescribeToolShapes(),
      "disc: a saw that cuts with its rim; ball: a burr that cuts with its whole surface; bur: a fissure or "
      "Lindemann bur, which cuts with its side and its end; drill: a twist drill, which cuts with the two lips of "
      "its tip; reciprocating: a blade that a stroke moves along its straight toothed edge; oscillating: a blade that "
      "swings about an axis behind the toothed arc at its end; piezo: a small saw insert whose toothed end vibrates "
      "along its teeth");
  for (std::size_t i = 0; i < GetDefaultTools().size(); ++i) EXPECT_EQ(GetDefaultTools()[i].index(), i);
  EXPECT_EQ(DescribeTool(DiscSaw{}), "disc 22 x 0.25 mm, 24 teeth");
  EXPECT_EQ(DescribeTool(BallBurr{}), "ball burr 6 mm, 8 flutes");
  EXPECT_EQ(DescribeTool(FissureBur{}), "bur 1.6 x 8 mm, 6 flutes");
  EXPECT_EQ(DescribeTool(TwistDrill{}), "drill 1.5 x 20 mm, point 118 degrees");
  FissureBur lindemann;
  lindemann.taper = 0.7;
  lindemann.point_angle_deg = 90;
  EXPECT_EQ(DescribeTool(OscillatingBlade{}), "oscillating blade 25 x 9 x 0.4 mm, teeth 1 mm apart, swing 5 degrees");
  EXPECT_EQ(DescribeTool(PiezoInsert{}), "piezo insert 10 x 4 x 0.5 mm, teeth 0.8 mm apart, stroke 0.12 mm");
  EXPECT_EQ(DescribeTool(lindemann), "bur 1.6 x 8 mm, 6 flutes, taper 0.7, point 90 degrees");
}

TEST(Tool, ValuesOutOfRangeAreNamed) {
  BallBurr ball;
  ball.flutes = 0;
  EXPECT_EQ(test::MessageOf([&] { Validate(ball); }), "flutes = 0 is below 1; valid range 1 to 100");
  EXPECT_NO_THROW(Validate(Tool(BallBurr{})));
  FissureBur bur;
  bur.point_angle_deg = 60;
  bur.length_mm = 1.4;
  EXPECT_EQ(test::MessageOf([&] { Validate(bur); }),
            "length_mm = 1.4 is too short for point_angle_deg = 60 and diameter_mm = 1.6: the tip alone is 1.39 mm "
            "long");
  OscillatingBlade wide;
  wide.radius_mm = 20;
  wide.width_mm = 25;
  EXPECT_EQ(test::MessageOf([&] { Validate(wide); }),
            "width_mm = 25 is above 1.2 times radius_mm = 20: the teeth would lie on the sides");
}

}  // namespace
}  // namespace kerf
