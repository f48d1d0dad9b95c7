// Tests that compare the tool coupled to a handle with an ordinary differential equation, with statics, and with finer
// steps.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "experiment/reference/cuts.h"
#include "kerf/error.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using namespace test;

ReferenceParams Params(const char* law, int steps_per_tick) {
  ReferenceParams params;
  params.law = ForceLaw(law);
  params.fineness.steps_per_tick = steps_per_tick;
  return params;
}

/// Returns the upward force on a disc that moves down at `speed`, `depth` deep in a half space. It is an integral over
/// the arc by the midpoint rule, with an error of 1e-5.
double CalcUp(const ToothForce& law, double depth, double speed) {
  if (!(depth > 0 && speed > 0)) return 0;
  const double alpha = std::acos(1 - depth / kR);
  const double E_star = EStar(kE_MPa, kNu, kSaw);
  constexpr int kIntervals = 200;
  double up = 0;
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = alpha * (i + 0.5) / kIntervals;
    up += 2 * law(speed * std::cos(phi) / (24 * 125.0), Cortical(E_star)) * std::cos(phi) * 24 /
          (2 * std::numbers::pi) * alpha / kIntervals;
  }
  return up;
}

/// Solves K (x_h - x) = F(x', x) for the depth x by the implicit midpoint rule, because the equation is stiff near the
/// surface. Finds x' by bisection.
std::vector<double> SolveDepths(const ToothForce& law, double K, double handle_mm_per_s, int ticks) {
  constexpr int kSteps = 4;
  const double h = 0.001 / kSteps;
  std::vector<double> depths;
  double x = 0;
  for (int i = 1; i <= kSteps * ticks; ++i) {
    double low = 0;
    double high = 2 * handle_mm_per_s;
    for (int n = 0; n < 45; ++n) {
      const double v = 0.5 * (low + high);
      const double depth = x + 0.5 * h * v;
      (CalcUp(law, depth, v) < K * (handle_mm_per_s * (i - 0.5) * h - depth) ? low : high) = v;
    }
    x += h * low;
    if (i % kSteps == 0) depths.push_back(x);
  }
  return depths;
}

TEST(ReferenceInHand, PlungeFollowsTheDifferentialEquation) {
  // The handle goes down at 10 mm/s, while the arc and the stretch of the spring grow.
  constexpr int kTicks = 300;
  const std::vector<Pose> poses = Stroke({0, 0, kR}, {0, 0, kR - 3}, 10);
  const ToothForce law = MakeToothForce(ForceLaw("hertz_chip"), kSaw);
  const std::vector<double> depths = SolveDepths(law, 2, 10, kTicks);
  double errors[2];
  for (const int n : {0, 1}) {
    ReferenceParams params = Params("hertz_chip", n == 0 ? 4 : 8);
    params.coupling.stiffness_N_per_mm = 2;
    const ReferenceRun run = RunReferenceInHand(HalfSpace(), params, poses);
    ASSERT_EQ(run.ticks.size(), depths.size());
    double worst = 0;
    for (int k = 0; k < kTicks; ++k) {
      const double depth = kR - run.ticks[k].X_WT.p_AB.z;
      worst = std::max(worst, std::abs(depth - depths[k]));
      // The tool is massless, so the force on the hand is the stretch times the stiffness.
      EXPECT_NEAR(run.ticks[k].f_W_N.z, 2 * (10 * 0.001 * (k + 1) - depth), 1e-9);
    }
    errors[n] = worst;
    const double up = run.ticks.back().f_W_N.z;
    EXPECT_GT(up, 0.5);
    EXPECT_NEAR(run.ticks.back().f_W_N.x, 0, 1e-6);
    // The removed volume is that of the segment.
    const double volume = SegmentArea(kR, kR - run.ticks.back().X_WT.p_AB.z) * kSaw.thickness_mm;
    EXPECT_NEAR(run.ticks.back().removed_mm3 / volume, 1, 2e-4);
    std::printf("plunge: depth off by %.2e mm, force at the end %.4f (%.4f) N, volume %.1e\n", worst, up,
                2 * (3 - depths.back()), run.ticks.back().removed_mm3 / volume - 1);
  }
  // The method is of first order: the error is within the handle's motion in one step.
  EXPECT_LT(errors[0], 2.5e-3);
  EXPECT_NEAR(errors[0] / errors[1], 2, 0.4);
}

/// Returns poses 3 mm down, then along x, with the handle ahead of the tool.
std::vector<Pose> DownAndAlong(double along_mm) {
  std::vector<Pose> poses = Stroke({-8, 0, kR + 0.1}, {-8, 0, kR - 3}, 20);
  Append(poses, Stroke({-8, 0, kR - 3}, {-8 + along_mm, 0, kR - 3}, 10));
  return poses;
}

/// Returns parameters for a device that also rotates: the tool is held at a grip 80 mm above the disc, which tilts
/// under the force.
ReferenceParams MakeGripParams(const char* law, int steps_per_tick) {
  ReferenceParams params = Params(law, steps_per_tick);
  params.coupling.stiffness_N_per_mm = 2;
  params.coupling.damping_Ns_per_mm = 0.002;
  params.coupling.p_TC_mm = {0, 0, 80};
  return params;
}

const Pose kBelow{{1, 0, 0, 0}, {0, 0, -15}};  // a block 30 mm high with its top at 0

TEST(ReferenceInHand, ConvergesWithFirstOrderInItsSteps) {
  const std::vector<Pose> poses = DownAndAlong(2);
  for (const char* law : {"hertz_chip", "edge_plus_chip"}) {
    std::vector<ReferenceRun> runs;
    for (const int steps : {2, 4, 8}) {
      runs.push_back(RunReferenceInHand(Block(kBelow, {60, 10, 30}), MakeGripParams(law, steps), poses));
    }
    double apart[2];
    for (const int i : {0, 1}) {
      double sum = 0;
      for (std::size_t k = 0; k < runs[i].ticks.size(); ++k) {
        const Vec3 d = runs[i].ticks[k].f_W_N - runs[i + 1].ticks[k].f_W_N;
        sum += glm::dot(d, d);
      }
      apart[i] = std::sqrt(sum / static_cast<double>(runs[i].ticks.size()));
    }
    std::printf("%s: apart %.2e, %.2e N rms of %.2f N\n", law, apart[0], apart[1],
                glm::length(runs[2].ticks.back().f_W_N));
    EXPECT_NEAR(apart[0] / apart[1], 2, 0.3) << law;
    EXPECT_LT(apart[1], 2e-4 * glm::length(runs[2].ticks.back().f_W_N)) << law;
  }
}

TEST(ReferenceInHand, ConvergesWithTheNumberOfRimPoints) {
  std::vector<Pose> poses = Stroke({0, 0, kR}, {0, 0, kR - 2}, 25);
  Append(poses, Stroke({0, 0, kR - 2}, {1, 0.2, kR - 2.2}, 20));
  std::vector<ReferenceRun> runs;
  for (const int points : {96, 192, 384}) {
    ReferenceParams params = MakeGripParams("hertz_chip", 1);
    params.fineness.rim_points = points;
    runs.push_back(RunReferenceInHand(Block(kBelow, {60, 10, 30}), params, poses));
  }
  double apart[2];
  for (const int i : {0, 1}) {
    double sum = 0;
    for (std::size_t k = 0; k < runs[i].ticks.size(); ++k) {
      const Vec3 d = runs[i].ticks[k].f_W_N - runs[i + 1].ticks[k].f_W_N;
      sum += glm::dot(d, d);
    }
    apart[i] = std::sqrt(sum / static_cast<double>(runs[i].ticks.size()));
  }
  std::printf("rim_points: apart %.2e, %.2e N rms of %.2f N\n", apart[0], apart[1],
              glm::length(runs[2].ticks.back().f_W_N));
  // Convergence is at least of first order.
  EXPECT_LT(apart[1], 0.6 * apart[0]);
}

TEST(ReferenceInHand, WallsHoldTheToolAgainstTheCoupling) {
  // The handle moves 5 mm down, then 0.8 mm sideways, along the spindle.
  std::vector<Pose> poses = Stroke({0, 0, kR}, {0, 0, kR - 5}, 25);
  Append(poses, Stroke({0, 0, kR - 5}, {0, 0.8, kR - 5}, 20));
  ReferenceParams params = Params("hertz_chip", 4);
  params.coupling.stiffness_N_per_mm = 1.5;
  const ReferenceRun run = RunReferenceInHand(HalfSpace(), params, poses);
  const ReferenceTick& out = run.ticks.back();
  // The force on the hand points towards the tool. It acts at the disc's centre above the kerf, with a lever arm of
  // about 9 mm, and tilts the disc a little about the kerf. This is resisted by walls of 1500 N/mm3 over some 80 mm2,
  // with a lever arm of 1 to 2 mm. The rim continues down in its new plane by some hundredths of a millimetre.
  EXPECT_NEAR(out.f_W_N.y, -1.5 * (0.8 - out.X_WT.p_AB.y), 1e-9);
  EXPECT_NEAR(out.X_WT.p_AB.y, 0, 0.03);
  EXPECT_GE(out.X_WT.p_AB.y, 0);
  std::printf("walls: %.5f mm to the side for %.3f N\n", out.X_WT.p_AB.y, out.f_W_N.y);
}

TEST(ReferenceInHand, ToolInAirMovesWithTheHandle) {
  const std::vector<Pose> poses = Stroke({-5, 3, kR + 0.4}, {5, -3, kR + 0.001}, 200);
  ReferenceParams params = MakeGripParams("hertz_chip", 4);
  const ReferenceRun run = RunReferenceInHand(HalfSpace(), params, poses);
  for (std::size_t k = 0; k < run.ticks.size(); ++k) {
    EXPECT_NEAR(glm::length(run.ticks[k].X_WT.p_AB - poses[k + 1].p_AB), 0, 1e-9);
    EXPECT_NEAR(glm::length(run.ticks[k].f_W_N), 0, 1e-9);
  }
  EXPECT_EQ(run.ticks.back().removed_mm3, 0);
}

TEST(ReferenceInHand, ReturnsNoMoreEnergyThanWasPutIn) {
  // The handle moves into the bone, is shaken there in all directions, and moves out again to the start. The hand's
  // work is not negative at the end, and at no time is it below the energy that the spring can still return.
  std::vector<Pose> poses;
  for (int i = 0; i <= 600; ++i) {
    const double t = i / 600.0;
    const double in = std::sin(std::numbers::pi * t);
    poses.push_back(Upright({3 * in * std::sin(9 * t), 0.5 * in * std::sin(40 * t), kR + 0.2 - 4 * in}));
  }
  for (const char* law : {"hertz_chip", "hertz_constant_bite"}) {
    const ReferenceRun run = RunReferenceInHand(Block(kBelow, {60, 10, 30}), MakeGripParams(law, 4), poses);
    double work_mJ = 0;
    double min_mJ = 0;
    double max_mJ = 0;
    for (std::size_t k = 1; k < run.ticks.size(); ++k) {
      const Vec3 mean = 0.5 * (run.ticks[k - 1].f_W_N + run.ticks[k].f_W_N);
      work_mJ -= glm::dot(mean, poses[k + 1].p_AB - poses[k].p_AB);
      min_mJ = std::min(min_mJ, work_mJ);
      max_mJ = std::max(max_mJ, work_mJ);
    }
    // The tolerance is the error of the trapezoidal rule where the force changes within a tick.
    EXPECT_GE(min_mJ, -2e-3) << law;
    EXPECT_GT(work_mJ, 0.2 * max_mJ) << law;  // the spring returned less than this
    EXPECT_NEAR(glm::length(run.ticks.back().f_W_N), 0, 1e-6);
    std::printf("%s: %.3f mJ in the end, at most %.3f, at least %.1e\n", law, work_mJ, max_mJ, min_mJ);
  }
}

TEST(ReferenceInHand, ToolHeldByAConstantForceCreeps) {
  // The push of 0.05 mm gives 0.1 N, less than the resistance of one engaged tooth of the edge.
  std::vector<Pose> poses = Stroke({0, 0, kR}, {0, 0, kR - 0.05}, 5);
  for (int i = 0; i < 200; ++i) poses.push_back(poses.back());
  ReferenceParams params = Params("edge_plus_chip", 4);
  params.coupling.stiffness_N_per_mm = 2;
  const ReferenceRun run = RunReferenceInHand(HalfSpace(), params, poses);
  for (std::size_t k = 20; k < run.ticks.size(); ++k) {
    const double speed = (run.ticks[k - 1].X_WT.p_AB.z - run.ticks[k].X_WT.p_AB.z) / 0.001;
    EXPECT_GE(speed, -1e-9);
    EXPECT_LE(speed, 0.02);
  }
  EXPECT_GT(run.ticks.back().f_W_N.z, 0.05);
}

TEST(ReferenceInHand, DoesNotDependOnTheFrame) {
  const Pose X_WB{glm::angleAxis(1.1, glm::normalize(Vec3(1, -2, 0.5))), {120, -35, 7}};
  std::vector<Pose> poses = DownAndAlong(0.5);
  const ReferenceParams params = MakeGripParams("hertz_chip", 2);
  const ReferenceRun at_home = RunReferenceInHand(Block(kBelow, {60, 10, 30}), params, poses);
  for (Pose& X : poses) X = Times(X_WB, X);
  const ReferenceRun moved = RunReferenceInHand(Block(Times(X_WB, kBelow), {60, 10, 30}), params, poses);
  for (std::size_t k = 0; k < at_home.ticks.size(); ++k) {
    // A rounding error of 3e-14 mm corresponds to 3e-9 N at the walls and, at the end of a bisection, to 1e-8 rad of
    // the rim.
    EXPECT_NEAR(glm::length(X_WB.Vector(at_home.ticks[k].f_W_N) - moved.ticks[k].f_W_N), 0, 1e-5);
  }
}

TEST(ReferenceInHand, ToolSetDownInBoneIsHeldAndNotPushedOut) {
  // The disc is entirely buried at the start, nearer to one face than to the other. The handle rests, then pulls along
  // the spindle.
  std::vector<Pose> poses(60, Upright({0, 0.4, -15}));
  for (int i = 0; i < 60; ++i) poses.push_back(Upright({0, 0.4 + 0.01 * i, -15}));
  const ReferenceRun run = RunReferenceInHand(Block(kBelow, {60, 3, 30}), Params("hertz_chip", 2), poses);
  for (std::size_t k = 0; k < run.ticks.size(); ++k) {
    // A force of 1 N on 380 mm2 of wall of 1500 N/mm3 gives 2e-6 mm.
    EXPECT_NEAR(run.ticks[k].X_WT.p_AB.y, 0.4, 1e-5);
    EXPECT_NEAR(run.ticks[k].f_W_N.y, -(poses[k + 1].p_AB.y - 0.4), 1e-4);
  }
}

TEST(ReferenceInHand, StoppedSpindleIsRefused) {
  ReferenceParams params = Params("hertz_chip", 4);
  params.rpm = 0;
  EXPECT_THROW(RunReferenceInHand(HalfSpace(), params, {Upright({0, 0, 20})}), Error);
}

}  // namespace
}  // namespace kerf
