// The Falcon's legs: inverse and forward kinematics, the Jacobian against finite differences, and conservation of
// power.
#include "device/devices/falcon/falcon_kinematics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "support/random_cases.h"

namespace kerf {
namespace {

constexpr double kSame_mm = 1e-6;  // 1e-9 m
constexpr double kRadius_mm = 40;

class FalconDraw {
 public:
  explicit FalconDraw(unsigned seed) : random_(seed) {}
  double Between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 InBox(double half) { return {Between(-half, half), Between(-half, half), Between(-half, half)}; }
  Vec3 InSphere(double radius) {
    for (;;) {
      const Vec3 p = InBox(radius);
      if (glm::length(p) <= radius) return p;
    }
  }

 private:
  std::mt19937 random_;
};

TEST(FalconKinematics, AgreesWithTheFiguresOfTheReference) {
  // Counts of the legs at positions on the axes, computed by a separate program from libnifalcon's geometry.
  struct Case {
    Vec3 p_D_mm;
    FalconCounts counts;
  };
  for (const Case& c :
       {Case{{0, 0, 0}, {-200, -200, -200}}, Case{{40, 0, 0}, {201, -718, 413}}, Case{{-40, 0, 0}, {-186, 553, -491}},
        Case{{0, 40, 0}, {-707, 160, 442}}, Case{{0, -40, 0}, {543, -145, -520}}, Case{{0, 0, 40}, {717, 717, 717}},
        Case{{0, 0, -40}, {-1129, -1129, -1129}}}) {
    const std::optional<FalconAngles> angles = CalcFalconAnglesAt(c.p_D_mm);
    ASSERT_TRUE(angles);
    EXPECT_EQ(CalcFalconCounts(*angles), c.counts);
  }
}

TEST(FalconKinematics, CountsAndAnglesAreEachOthersInverse) {
  for (int count = -32768; count <= 32767; ++count) {
    ASSERT_EQ(CalcFalconCounts(CalcFalconAngles({count, -count / 2, 7})), (FalconCounts{count, -count / 2, 7}));
  }
}

TEST(FalconKinematics, ForwardUndoesInverseOverTheWorkspace) {
  // The solver starts from the middle each time, which is harder than from a neighbouring position.
  FalconDraw draw(1);
  double worst = 0;
  for (int i = 0; i < 200000; ++i) {
    const Vec3 p = draw.InSphere(kRadius_mm);
    const std::optional<FalconAngles> angles = CalcFalconAnglesAt(p);
    ASSERT_TRUE(angles) << i;
    FalconForward forward;
    ASSERT_TRUE(forward.Solve(*angles)) << p.x << " " << p.y << " " << p.z;
    worst = std::max(worst, glm::length(forward.p_D_mm() - p));
  }
  EXPECT_LT(worst, kSame_mm);
}

TEST(FalconKinematics, InverseUndoesForwardOverTheCounts) {
  // The counts are from -1400 to 1000 and belong to a position within reach; they are found by rounding the counts of
  // random positions.
  FalconDraw draw(2);
  FalconForward forward;
  int inside = 0;
  double worst_rad = 0;
  int lowest = 0;
  int highest = 0;
  for (int i = 0; i < 300000; ++i) {
    const Vec3 p = draw.InBox(60);
    const std::optional<FalconAngles> rough = CalcFalconAnglesAt(p);
    if (!rough) continue;
    const FalconCounts counts = CalcFalconCounts(*rough);
    const auto [low, high] = std::minmax_element(counts.begin(), counts.end());
    if (*low < -1400 || *high > 1000) continue;
    ++inside;
    lowest = std::min(lowest, *low);
    highest = std::max(highest, *high);
    const FalconAngles angles = CalcFalconAngles(counts);
    if (!forward.Solve(angles)) {
      // Rounding may move a position out of reach, but only near the edge, where a leg is stretched.
      const std::optional<glm::dmat3> J = CalcFalconJacobian(p);
      ASSERT_TRUE(!J || glm::length((*J)[0]) + glm::length((*J)[1]) + glm::length((*J)[2]) > 0.2)
          << p.x << " " << p.y << " " << p.z;
      continue;
    }
    const std::optional<FalconAngles> back = CalcFalconAnglesAt(forward.p_D_mm());
    ASSERT_TRUE(back);
    for (std::size_t k = 0; k < 3; ++k) worst_rad = std::max(worst_rad, std::abs((*back)[k] - angles[k]));
  }
  EXPECT_GT(inside, 50000);
  EXPECT_LT(lowest, -1390);
  EXPECT_GT(highest, 990);
  // This angle is 1e-9 m at the end of an arm of 60 mm.
  EXPECT_LT(worst_rad, kSame_mm / 60);
}

TEST(FalconKinematics, JacobianIsTheDerivative) {
  // The error of central differences with h = 0.01 mm is h^2 times a third derivative, about 1e-4 / 60^3 rad/mm.
  FalconDraw draw(3);
  constexpr double h = 0.01;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = draw.InSphere(kRadius_mm);
    const std::optional<glm::dmat3> J = CalcFalconJacobian(p);
    ASSERT_TRUE(J);
    for (int k = 0; k < 3; ++k) {
      Vec3 step{0};
      step[k] = h;
      const std::optional<FalconAngles> up = CalcFalconAnglesAt(p + step);
      const std::optional<FalconAngles> down = CalcFalconAnglesAt(p - step);
      ASSERT_TRUE(up && down);
      for (int leg = 0; leg < 3; ++leg) {
        const auto at = static_cast<std::size_t>(leg);
        ASSERT_NEAR((*J)[k][leg], ((*up)[at] - (*down)[at]) / (2 * h), 2e-8);
      }
    }
  }
}

TEST(FalconKinematics, JointPowerEqualsGripPower) {
  FalconDraw draw(4);
  for (int i = 0; i < 100000; ++i) {
    const Vec3 p = draw.InSphere(kRadius_mm);
    const Vec3 v = draw.InBox(1000);
    const Vec3 f = draw.InBox(10);
    const std::optional<Vec3> tau = CalcFalconTorques(p, f);
    const std::optional<glm::dmat3> J = CalcFalconJacobian(p);
    ASSERT_TRUE(tau && J);
    const double size = glm::length(f) * glm::length(v);
    ASSERT_NEAR(glm::dot(*tau, *J * v), glm::dot(f, v), 1e-11 * size);
    const std::optional<Vec3> back = CalcFalconForce(p, *tau);
    ASSERT_TRUE(back);
    ASSERT_LT(glm::length(*back - f), 1e-12 * (1 + glm::length(f)));
  }
}

TEST(FalconKinematics, NeverLosesTheGripOnARandomPath) {
  // Smooth random paths at 1 kHz in the sphere, up to about 2 m/s; each step starts from the result of the last one.
  FalconDraw draw(5);
  FalconForward forward;
  Vec3 p{0};
  Vec3 v{0};
  double worst = 0;
  double fastest = 0;
  std::int64_t steps = 0;
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    v += 0.001 * (draw.InBox(30000) - 200.0 * p - 3.0 * v);
    if (glm::length(p + 0.001 * v) > kRadius_mm) v = -0.5 * v;
    p += 0.001 * v;
    if (glm::length(p) > kRadius_mm) p *= kRadius_mm / glm::length(p);
    fastest = std::max(fastest, glm::length(v));
    const std::optional<FalconAngles> angles = CalcFalconAnglesAt(p);
    ASSERT_TRUE(angles) << i;
    ASSERT_TRUE(forward.Solve(*angles)) << i;
    worst = std::max(worst, glm::length(forward.p_D_mm() - p));
    steps += forward.steps();
  }
  EXPECT_LT(worst, kSame_mm);
  EXPECT_GT(fastest, 500);
  EXPECT_LT(static_cast<double>(steps) / cases, 6);
}

TEST(FalconKinematics, KeepsTheLastPositionIfThereIsNoSolution) {
  FalconForward forward;
  const Vec3 p(10, -5, 20);
  ASSERT_TRUE(forward.Solve(*CalcFalconAnglesAt(p)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const FalconAngles& impossible :
       {FalconAngles{3, -3, 3}, FalconAngles{-2, 1.5, -2}, FalconAngles{nan, 0, 0}, FalconAngles{0, infinity, 0}}) {
    EXPECT_FALSE(forward.Solve(impossible));
    EXPECT_LT(glm::length(forward.p_D_mm() - p), kSame_mm);
  }
  // The solver also follows a jump to the far side.
  const Vec3 far(-20, 15, -30);
  ASSERT_TRUE(forward.Solve(*CalcFalconAnglesAt(far)));
  EXPECT_LT(glm::length(forward.p_D_mm() - far), kSame_mm);
}

TEST(FalconKinematics, ReportsPositionsOutOfReach) {
  for (const Vec3& p : {Vec3(0, 0, 200), Vec3(300, 0, 0), Vec3(0, 0, -1e9), Vec3(1e300, 0, 0),
                        Vec3(std::numeric_limits<double>::quiet_NaN(), 0, 0)}) {
    EXPECT_FALSE(CalcFalconAnglesAt(p));
    EXPECT_FALSE(CalcFalconJacobian(p));
    EXPECT_FALSE(CalcFalconTorques(p, Vec3(1, 0, 0)));
    EXPECT_FALSE(CalcFalconForce(p, Vec3(1, 0, 0)));
  }
}

}  // namespace
}  // namespace kerf
