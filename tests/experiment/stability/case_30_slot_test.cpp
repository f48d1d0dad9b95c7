// Hard case 30: bone on both sides of the disc, in a slot as wide as the disc or narrower.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bone/grid/build.h"
#include "cut/contact/step.h"
#include "cut/hand_sim/hands.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::Verdict;

/// Returns a block of 30 x 6 x 24 mm with its top at z = 12 and a slot in the plane y = 0 from the top down to z = -1.
/// The disc is upright in the slot, with its centre at z = 11.
Bone MakeSlottedBlock(double width_mm, double voxel_mm) {
  SolidField field;
  field.value = [width_mm](const Vec3& p) {
    const double block = test::BoxDistance(p, {15, 3, 12});
    const double slot = test::BoxDistance(p - Vec3(0, 0, 9), {40, 0.5 * width_mm, 10});
    return std::max(block, -slot);
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  return MakeBone(field, Box3{{-17, -5, -14}, {17, 5, 14}}, {voxel_mm, voxel_mm, {}}, test::OneRegionTable());
}

TEST(HardCase30, ASymmetricSlotPushesToNeitherSide) {
  Verdict verdict("holds");
  double worst_N = 0;
  double worst_moment_Nmm = 0;
  double min_touching_N = 1e9;
  // The slot is wider than the disc, as wide, and narrower by a fifth (as the grid may represent it).
  for (const double width_mm : {0.4, 0.25, 0.2}) {
    const Bone bone = MakeSlottedBlock(width_mm, 0.1);
    for (const double rpm : {7500.0, 0.0}) {
      const Pose X = DiscPose(Pose{}, {0, 0, 11});
      CoupledSimulation simulation(bone, test::DiscParams(), X);
      CoupledOutput out;
      for (int i = 0; i < 300; ++i) {
        // The motion is straight up and down, so any friction acts along z.
        out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 11 + 0.2 * std::sin(0.05 * i)}), rpm));
        worst_N = std::max(worst_N, std::abs(out.f_H_W_N.y));
        worst_moment_Nmm = std::max(worst_moment_Nmm, std::abs(out.tau_H_W_Nmm.x) + std::abs(out.tau_H_W_Nmm.z));
      }
      // Checks that there is contact: the walls resist a push to either side.
      for (const double side : {1.0, -1.0}) {
        for (int i = 0; i < 100; ++i) out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 2 * side, 11}), rpm));
        min_touching_N = std::min(min_touching_N, -side * out.f_H_W_N.y);
      }
    }
  }
  verdict.AtMost("force across the slot", worst_N, 1e-6, "N");
  verdict.AtMost("torque out of the slot's plane", worst_moment_Nmm, 1e-5, "N mm");
  verdict.AtLeast("wall force when pushed by 2 mm at 1 N/mm", min_touching_N, 1.8, "N");
}

TEST(HardCase30, ForceDoesNotDependOnTheSideThatTheHandCameFrom) {
  Verdict verdict("holds");
  // The disc is pushed against one wall with 2 N and returns to the middle; the same is done from the other side.
  double difference_N = 0;
  double left_N = 0;
  for (const double width_mm : {0.4, 0.25}) {
    const Bone bone = MakeSlottedBlock(width_mm, 0.1);
    double f[2][200];
    for (const int side : {0, 1}) {
      const double sign = side == 0 ? 1 : -1;
      CoupledSimulation simulation(bone, test::DiscParams(), DiscPose(Pose{}, {0, 0, 11}));
      for (int i = 0; i < 200; ++i) {
        const double y = i < 100 ? 0.02 * i : std::max(0.0, 2 - 0.04 * (i - 100));
        const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, sign * y, 11})));
        f[side][i] = sign * out.f_H_W_N.y;
      }
      left_N = std::max(left_N, std::abs(f[side][199]));
    }
    for (int i = 0; i < 200; ++i) difference_N = std::max(difference_N, std::abs(f[0][i] - f[1][i]));
  }
  verdict.AtMost("force difference between the two sides", difference_N, 1e-6, "N");
  verdict.AtMost("force left in the middle", left_N, 1e-6, "N");
}

TEST(HardCase30, TheStepHasOneSolutionWhereverTheSearchBegins) {
  Verdict verdict("holds");
  // The flats are supported from both sides at points that are already inside the bone, at different depths.
  StepProblem problem;
  problem.tau_s = 0.001;
  problem.coupling.spring = {1, 40};
  problem.coupling.torsion = {5000, 4000};
  problem.coupling.damper = {0, 40};
  problem.coupling.torsion_damper = {0, 4000};
  problem.coupling.x_mm = {0.3, -0.2, 0.5};
  problem.coupling.theta_rad = {0.01, -0.02, 0.03};
  problem.flat_stiffness_N_per_mm = 3000;
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.7 * i;
    const double r = 2 + 0.13 * i;
    for (const double side : {1.0, -1.0}) {
      problem.flats.push_back({side, r * std::cos(angle), r * std::sin(angle), 0.001 * ((i * 7) % 5 - 1)});
    }
  }
  problem.frictions.push_back({MakeRow({1, 0, 0}, {3, 4, 0}), MakeRow({0, 1, 0}, {3, 4, 0}), 100, -50, 2});
  StepSolver solver(256);
  const Twist first = solver.Solve(problem, Twist{}, kR, 100).u;
  double worst = 0;
  for (const double speed : {1e3, -1e3, 1e-3, 37.0}) {
    for (int axis = 0; axis < 6; ++axis) {
      Twist start{};
      start[axis] = speed;
      const StepSolution found = solver.Solve(problem, start, kR, 100);
      EXPECT_TRUE(found.converged);
      for (int k = 0; k < 6; ++k) worst = std::max(worst, std::abs(found.u[k] - first[k]) * (k < 3 ? 1 : kR));
    }
  }
  // Forces balance within a relative error of 1e-8. This is multiplied by 1 mm/s per newton of the softest term, which
  // is friction.
  verdict.AtMost("difference between the motions found from 24 starting points", worst, 1e-5, "mm/s");
}

}  // namespace
}  // namespace kerf
