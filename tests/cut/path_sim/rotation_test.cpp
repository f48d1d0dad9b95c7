// Force and torque of a tool that a path turns, compared with closed forms. The thrust of a tooth rises with the power
// 3/2 of its bite, so that of an edge part is K times the power of its speed.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kerf/simulation.h"
#include "support/cuts.h"

namespace kerf {
namespace {

constexpr double kPower = 1.5;  // of hertz_chip
constexpr double kTurnTick_s = 1e-3;

/// Integral of x^power from a to b.
double CalcIntegral(double a, double b, double power) {
  return (std::pow(b, power + 1) - std::pow(a, power + 1)) / (power + 1);
}

struct TurnLoad {
  Vec3 f_T_N{0};
  Vec3 tau_T_Nmm{0};  // about the tool's origin
  double engaged_teeth = 0;
  double mean_bite_mm = 0;
};

/// Returns the load in the first tick of a motion from X_WT: velocity (mm/s) and angular velocity (rad/s) in its frame.
TurnLoad MoveFrom(const Pose& X_WT, const Bone& bone, const SimulationParams& params, const Vec3& p_TG_mm,
                  const Vec3& v_T, const Vec3& w_T) {
  Simulation simulation(bone, params, X_WT);
  Pose X = {X_WT.R_AB, X_WT.Point(kTurnTick_s * v_T)};
  const double angle = kTurnTick_s * glm::length(w_T);
  if (angle > 0) X.R_AB = X_WT.R_AB * glm::angleAxis(angle, glm::normalize(w_T));
  const TickOutput out = simulation.Tick({X, kTurnTick_s, 15000});
  TurnLoad load{X_WT.InverseVector(out.f_T_W_N), X_WT.InverseVector(out.tau_TG_W_Nmm), out.engaged_teeth,
                out.mean_bite_mm};
  load.tau_T_Nmm += glm::cross(p_TG_mm, load.f_T_N);
  return load;
}

TEST(Rotation, TurnedBurCutsWithTheSpeedOfEachHeightOfItsSide) {
  // A plate from z = 1 to z = 4 mm above the tip. Rings of points are 0.05 mm apart: the plate's ends are known to half
  // of that, 2 % of the height, or 2.5 % where the speed is highest.
  FissureBur bur;
  bur.diameter_mm = 2;
  SimulationParams params;
  params.tool = bur;
  params.law = ForceLaw("hertz_chip");
  params.rim_samples_per_pitch = 128;
  constexpr double kLow_mm = 1, kHigh_mm = 4, kSpeed_mm_per_s = 2, kTurn_rad_per_s = 0.8, kPlateTolerance = 0.025;
  for (const std::size_t n : {0u, 5u, 7u}) {
    const Pose X_WT = test::BlockPoses(0.1)[n];
    const Bone plate =
        test::MakeBox({X_WT.R_AB, X_WT.Point({0, 0, 0.5 * (kLow_mm + kHigh_mm)})}, {8, 8, kHigh_mm - kLow_mm}, 0.1);
    const auto move = [&](const Vec3& v, const Vec3& w) { return MoveFrom(X_WT, plate, params, bur.p_TG_mm, v, w); };
    const TurnLoad straight = move({kSpeed_mm_per_s, 0, 0}, Vec3(0));
    const double K = -straight.f_T_N.x / (std::pow(kSpeed_mm_per_s, kPower) * (kHigh_mm - kLow_mm));
    EXPECT_GT(K, 0);
    // The torque is that of the force at half the plate's height.
    EXPECT_NEAR(straight.tau_T_Nmm.y / straight.f_T_N.x, 0.5 * (kLow_mm + kHigh_mm), kPlateTolerance);

    // About the tip, height z moves along x with kTurn z.
    const TurnLoad tip = move(Vec3(0), {0, kTurn_rad_per_s, 0});
    const double force_N = K * std::pow(kTurn_rad_per_s, kPower) * CalcIntegral(kLow_mm, kHigh_mm, kPower);
    const double torque_Nmm = K * std::pow(kTurn_rad_per_s, kPower) * CalcIntegral(kLow_mm, kHigh_mm, kPower + 1);
    EXPECT_NEAR(tip.f_T_N.x / -force_N, 1, kPlateTolerance);
    EXPECT_NEAR(tip.tau_T_Nmm.y / -torque_Nmm, 1, kPlateTolerance);
    EXPECT_NEAR(glm::length(Vec3(0, tip.f_T_N.y, tip.f_T_N.z)), 0, 0.01 * force_N);

    // The same half of the side cuts as in a straight motion, with the speed of its middle on average.
    EXPECT_NEAR(tip.engaged_teeth / straight.engaged_teeth, 1, 1e-3);
    EXPECT_NEAR(
        tip.mean_bite_mm / straight.mean_bite_mm / (kTurn_rad_per_s * 0.5 * (kLow_mm + kHigh_mm) / kSpeed_mm_per_s), 1,
        0.01);

    // About the middle of the plate, the forces of the two halves cancel, and their torques add.
    const double half = 0.5 * (kHigh_mm - kLow_mm);
    const TurnLoad middle = move({-kTurn_rad_per_s * 0.5 * (kLow_mm + kHigh_mm), 0, 0}, {0, kTurn_rad_per_s, 0});
    const double couple_Nmm = 2 * K * std::pow(kTurn_rad_per_s, kPower) * CalcIntegral(0, half, kPower + 1);
    EXPECT_NEAR(middle.f_T_N.x, 0, 0.05 * force_N);
    EXPECT_NEAR((middle.tau_T_Nmm.y - 0.5 * (kLow_mm + kHigh_mm) * middle.f_T_N.x) / -couple_Nmm, 1,
                2 * kPlateTolerance);

    // About the spindle, nothing is cut.
    EXPECT_LT(glm::length(move(Vec3(0), {0, 0, kTurn_rad_per_s}).f_T_N), 1e-9);
  }
}

TEST(Rotation, BladeTurnedInItsPlaneCutsWithTheSpeedOfEachPlaceOfItsEdge) {
  // The block reaches from 0.5 to 4.5 mm along the edge. At its ends the grid rounds off corners, by less than a voxel
  // in 40.
  ReciprocatingBlade blade;
  blade.length_mm = 16;
  SimulationParams params;
  params.tool = blade;
  params.law = ForceLaw("hertz_chip");
  constexpr double kNear_mm = 0.5, kFar_mm = 4.5, kSpeed_mm_per_s = 2, kTurn_rad_per_s = 0.8, kBlockTolerance = 0.025;
  for (const std::size_t n : {0u, 5u, 7u}) {
    const Pose X_WT = test::BlockPoses(0.1)[n];
    const Bone block =
        test::MakeBox({X_WT.R_AB, X_WT.Point({0, 0.5 * (kNear_mm + kFar_mm), 0})}, {6, kFar_mm - kNear_mm, 3}, 0.1);
    const auto move = [&](const Vec3& v, const Vec3& w) { return MoveFrom(X_WT, block, params, blade.p_TG_mm, v, w); };
    const TurnLoad straight = move({kSpeed_mm_per_s, 0, 0}, Vec3(0));
    const double K = -straight.f_T_N.x / (std::pow(kSpeed_mm_per_s, kPower) * (kFar_mm - kNear_mm));
    EXPECT_GT(K, 0);
    const TurnLoad turned = move(Vec3(0), {0, 0, -kTurn_rad_per_s});
    const double force_N = K * std::pow(kTurn_rad_per_s, kPower) * CalcIntegral(kNear_mm, kFar_mm, kPower);
    EXPECT_NEAR(turned.f_T_N.x / -force_N, 1, kBlockTolerance);
    EXPECT_NEAR(
        turned.tau_T_Nmm.z / (K * std::pow(kTurn_rad_per_s, kPower) * CalcIntegral(kNear_mm, kFar_mm, kPower + 1)), 1,
        kBlockTolerance);
    EXPECT_NEAR(turned.engaged_teeth / straight.engaged_teeth, 1, 1e-3);
    EXPECT_NEAR(
        turned.mean_bite_mm / straight.mean_bite_mm / (kTurn_rad_per_s * 0.5 * (kNear_mm + kFar_mm) / kSpeed_mm_per_s),
        1, 0.01);
    // Out of its plane, no tooth moves into the bone. The other way, all teeth move back.
    EXPECT_LT(glm::length(move(Vec3(0), {0, kTurn_rad_per_s, 0}).f_T_N), 0.01 * force_N);
    EXPECT_EQ(move(Vec3(0), {0, 0, kTurn_rad_per_s}).f_T_N, Vec3(0));
  }
}

TEST(Rotation, DiscAndBallTurnedAboutTheirMiddleCutAsIfTheyWereNot) {
  for (const Tool& tool : {Tool(DiscSaw{}), Tool(BallBurr{})}) {
    SimulationParams params;
    params.tool = tool;
    const Pose X_WT = test::BlockPoses(0.1)[5];
    const Bone block = test::MakeBox({X_WT.R_AB, X_WT.Point({CalcRadius(tool), 0, 0})}, {4, 4, 4}, 0.1);
    const auto move = [&](const Vec3& w) { return MoveFrom(X_WT, block, params, Vec3(0), {2, 0, 0}, w); };
    const TurnLoad straight = move(Vec3(0));
    const TurnLoad turned = move({0.1, 0.2, 0.3});
    EXPECT_LT(straight.f_T_N.x, 0);
    EXPECT_EQ(turned.f_T_N, straight.f_T_N);
    EXPECT_EQ(turned.tau_T_Nmm, straight.tau_T_Nmm);
    EXPECT_EQ(turned.engaged_teeth, straight.engaged_teeth);
    EXPECT_EQ(turned.mean_bite_mm, straight.mean_bite_mm);
  }
}

TEST(Rotation, RoundingOfARestingRotationMovesNoTooth) {
  // The pose of a path is interpolated between equal rotations, which changes its last bits. With a law whose force
  // does not fall to 0 with the bite, that would be a force at rest.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> last_bits(-2e-16, 2e-16);
  for (const Tool& tool : {Tool(FissureBur{}), Tool(ReciprocatingBlade{})}) {
    SimulationParams params;
    params.tool = tool;
    params.law = ForceLaw("hertz_constant_bite");
    for (const int substeps : {1, 4}) {
      params.substeps = substeps;
      const Pose X_WT = test::BlockPoses(0.1)[5];
      Simulation simulation(test::MakeBox(X_WT, {6, 6, 6}, 0.1), params, X_WT);
      for (int i = 0; i < 100; ++i) {
        Pose X = X_WT;
        for (int k = 0; k < 4; ++k) X.R_AB[k] += last_bits(random);
        const TickOutput out = simulation.Tick({X, kTurnTick_s, 15000});
        EXPECT_EQ(out.f_T_W_N, Vec3(0));
        EXPECT_EQ(out.engaged_teeth, 0);
      }
    }
  }
}

}  // namespace
}  // namespace kerf
