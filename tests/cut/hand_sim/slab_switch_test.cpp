// Special cases of the slab's law: the tool is lifted away, the spindle is stopped, or the law is used very briefly.
// Also the direction of the spinning disc's friction.
#include <gtest/gtest.h>

#include <cmath>

#include "cut/hand_sim/hands.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

const double kClear = 5 + kR + 0.2;  // height of the disc's centre at which the rim is just above the block

/// Returns a simulation with the disc above a block of 40 x 2 x 10 mm with its top at z = 5.
CoupledSimulation Start(double x, const CoupledParams& params = test::DiscParams()) {
  return CoupledSimulation(test::MakeBox(Pose{}, {40, 2, 10}, 0.1), params, DiscPose(Pose{}, {x, 0, kClear}));
}

/// Moves down at 3 mm/s from the block's top; the depth is that of the handle.
CoupledOutput Plunge(CoupledSimulation& simulation, double x, double from_mm, double to_mm) {
  CoupledOutput out;
  const int ticks = static_cast<int>(std::abs(to_mm - from_mm) / 0.003);
  for (int i = 1; i <= ticks; ++i) {
    const double depth = from_mm + (to_mm - from_mm) * i / ticks;
    out = simulation.Tick(Handle(DiscPose(Pose{}, {x, 0, kClear - depth})));
  }
  return out;
}

TEST(CoupledSlabSwitch, ToolSetDownElsewhereCutsNothingOnTheWay) {
  CoupledSimulation simulation = Start(-15);
  Plunge(simulation, -15, 0, 2);
  simulation.SetFidelity(Fidelity::kSlab);
  ASSERT_EQ(Plunge(simulation, -15, 2, 4).fidelity, Fidelity::kSlab);
  const Pose elsewhere = DiscPose(Pose{}, {15, 0, kClear + 3});
  ASSERT_TRUE(simulation.SetDown(elsewhere));
  simulation.SetFidelity(Fidelity::kFull);
  double removed = 0;
  for (int i = 0; i < 500; ++i) removed += simulation.Tick(Handle(elsewhere)).removed_mm3;
  EXPECT_EQ(removed, 0);
  EXPECT_LT(simulation.UpdateBone().SignedDistance({0, 0, 4.5}), 0);
}

TEST(CoupledSlabSwitch, ShortUseLeavesNoPendingCut) {
  CoupledSimulation simulation = Start(-15);
  Plunge(simulation, -15, 0, 2);
  simulation.SetFidelity(Fidelity::kSlab);
  Plunge(simulation, -15, 2, 2.75);  // slightly longer than the transition takes
  simulation.SetFidelity(Fidelity::kFull);
  Plunge(simulation, -15, 2.75, -1);
  for (int i = 0; i <= 3000; ++i) simulation.Tick(Handle(DiscPose(Pose{}, {-15 + 0.01 * i, 0, kClear + 1})));
  Plunge(simulation, 15, -1, 2);
  simulation.SetFidelity(Fidelity::kSlab);
  ASSERT_EQ(Plunge(simulation, 15, 2, 4).fidelity, Fidelity::kSlab);
  simulation.SetFidelity(Fidelity::kFull);
  Plunge(simulation, 15, 4, -1);
  EXPECT_LT(simulation.UpdateBone().SignedDistance({0, 0, 4.5}), -0.2);
}

TEST(CoupledSlabSwitch, AStoppedSpindleCutsNothingMoreAndGoesNoDeeper) {
  CoupledSimulation simulation = Start(0);
  Plunge(simulation, 0, 0, 2);
  simulation.SetFidelity(Fidelity::kSlab);
  const CoupledOutput before = Plunge(simulation, 0, 2, 4);
  ASSERT_EQ(before.fidelity, Fidelity::kSlab);
  // The space that the disc has passed through is removed: a segment of the disc, down to where it stopped.
  CoupledOutput out;
  for (int i = 0; i < 1500; ++i) {
    const double depth = 4 + std::min(0.01 * i, 8.0);  // the hand continues for 8 mm
    out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, kClear - depth}), 0));
    ASSERT_LE(glm::length(out.f_H_W_N), simulation.params().coupling.max_force_N * (1 + 1e-9));
  }
  // The edge's springs, many of 2000 N/mm each, yield less than 0.01 mm under 10 N; before that, the guide's springs
  // yield 3 um until those of the edge take over.
  EXPECT_NEAR(out.X_WT.p_AB.z, before.X_WT.p_AB.z, 0.02);
  const double depth = 5 + kR - before.X_WT.p_AB.z;
  double removed = 0;
  for (const double mm3 : simulation.CalcRemovedByRegion()) removed += mm3;
  EXPECT_NEAR(removed / (kSaw.thickness_mm * test::SegmentArea(kR, depth)), 1, 0.02);
}

TEST(CoupledSlabSwitch, RequestedBoneIncludesThePendingRemoval) {
  CoupledSimulation simulation = Start(0);
  Plunge(simulation, 0, 0, 2);
  simulation.SetFidelity(Fidelity::kSlab);
  const CoupledOutput out = Plunge(simulation, 0, 2, 5);
  ASSERT_EQ(out.fidelity, Fidelity::kSlab);
  const double depth = 5 + kR - out.X_WT.p_AB.z;
  EXPECT_GT(simulation.UpdateBone().SignedDistance({0, 0, 5 - depth + 0.1}), 0);
  double removed = 0;
  for (const double mm3 : simulation.CalcRemovedByRegion()) removed += mm3;
  EXPECT_NEAR(removed / (kSaw.thickness_mm * test::SegmentArea(kR, depth)), 1, 0.02);
}

TEST(CoupledInput, NearlyStoppedSpindleCountsAsStopped) {
  CoupledSimulation simulation = Start(0);
  for (const double rpm : {1e-300, 5e-324, 0.99, -0.5}) {
    for (int i = 0; i < 50; ++i) {
      const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, kClear - 1}), rpm));
      EXPECT_NE(out.status & kCoupledSpindleStopped, 0u);
      EXPECT_EQ(out.removed_mm3, 0);
      EXPECT_TRUE(std::isfinite(out.thrust_sum_N + out.mean_bite_mm + out.cut_mJ + out.numerical_mJ));
    }
  }
}

TEST(CoupledFriction, OpposesTheMotionOfTheFlats) {
  // The disc is pushed sideways against a wall of its kerf: its lowest part touches. If the disc turns about +z of the
  // tool, its flats move along z x r there. Friction opposes this motion, so it reverses with the spindle.
  double along[2];
  for (const int side : {0, 1}) {
    CoupledSimulation simulation = Start(0);
    const double rpm = side == 0 ? 7500 : -7500;
    CoupledOutput out;
    for (int i = 1; i <= 2000; ++i) {
      const double down = std::min(0.003 * i, 4.5);
      const double push = i > 1500 ? 0.3 : 0;  // sideways, N, through the coupling of 1 N/mm
      out = simulation.Tick(Handle(DiscPose(Pose{}, {0, push, kClear - down}), rpm));
    }
    along[side] = out.f_friction_W_N.x;
    // The contact is below the centre: r = -z of the block, and in DiscPose the tool's z is along the block's y.
    const Vec3 flats_go = (rpm > 0 ? 1.0 : -1.0) * glm::cross(out.X_WT.Vector({0, 0, 1}), Vec3(0, 0, -1));
    EXPECT_LT(along[side] * flats_go.x, -0.01);
  }
  EXPECT_NEAR(along[0], -along[1], 0.2 * std::abs(along[0]));
}

TEST(CoupledGrip, FrictionDoesNotRunAwayWithAGripFarFromTheDisc) {
  // The handle is 80 mm above the disc: if the hand tilts it, the flats press on both walls, friction pulls the disc
  // along, and this tilts it further. A thin disc bends before this becomes unstable: it does not kick, and the spindle
  // does little work.
  CoupledParams params = test::DiscParams();
  params.coupling.p_TC_mm = {0, 0, 80};
  CoupledSimulation simulation = Start(0, params);
  Vec3 last(0);
  double worst_step_N = 0;
  double spindle_mJ = 0;
  for (int i = 1; i <= 5000; ++i) {
    Pose X = DiscPose(Pose{}, {0, 0.00006 * i, kClear - 0.002 * i});
    X.R_AB = glm::angleAxis(std::min(0.00001 * i, 0.03), Vec3(1, 0, 0)) * X.R_AB;
    const CoupledOutput out = simulation.Tick(Handle(X));
    if (i > 200) worst_step_N = std::max(worst_step_N, glm::length(out.f_H_W_N - last));
    last = out.f_H_W_N;
    spindle_mJ += out.spindle_mJ;
    ASSERT_LT(std::abs(out.X_WT.p_AB.x), 2) << i;
  }
  EXPECT_LT(worst_step_N, 0.1);
  EXPECT_LT(spindle_mJ, 30);
}

}  // namespace
}  // namespace kerf
