// A tool represented by points: they lie on its surface and represent its number of teeth, for any sampling.
#include "cut/tool/shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

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
    const ToolShape shape = MakeToolShape(disc, samples, 1, 0.15, 0.1);
    EXPECT_TRUE(shape.edge_is_ring);
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
  const ToolShape shape = MakeToolShape(disc, 8, spacing, 0.3, 0.3);
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
  const ToolShape shape = MakeToolShape(DiscSaw{}, 8, 0.9, 0.3, 0.15);
  int stopped = 0;
  for (const FacePoint& p : shape.faces) {
    EXPECT_EQ(p.while_stopped, std::hypot(p.p_T.x, p.p_T.y) > 10.7 + 1e-9);
    stopped += p.while_stopped ? 1 : 0;
  }
  EXPECT_GT(stopped, 100);  // both sides of a ring of 68 mm, every 0.9 mm
}

TEST(ToolShape, BallHasFlutesTimesTheirLengthOfEdge) {
  // Each flute is half a great circle, pi r long.
  BallBurr ball;
  ball.flutes = 10;
  ball.tooth_width_mm = 0.25;
  for (const int samples : {4, 8, 16, 64}) {
    const ToolShape shape = MakeToolShape(ball, samples, 1, 0, 0);
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
    const ToolShape shape = MakeToolShape(ball, i == 0 ? 16 : 64, 1, 0, 0);
    double sum = 0;
    for (const EdgePoint& p : shape.edge) sum += p.teeth * std::max(0.0, p.e_T.x);
    error[i] = std::abs(sum / exact - 1);
  }
  EXPECT_LT(error[0], 0.005);         // midpoint rule, 16 x 32 points
  EXPECT_LT(error[1], error[0] / 8);  // exact second order would give 1/16
}

TEST(Tool, ValuesOutOfRangeAreNamed) {
  BallBurr ball;
  ball.flutes = 0;
  EXPECT_EQ(test::MessageOf([&] { Validate(ball); }), "flutes = 0 is below 1; valid range 1 to 100");
  EXPECT_NO_THROW(Validate(Tool(BallBurr{})));
}

}  // namespace
}  // namespace kerf
