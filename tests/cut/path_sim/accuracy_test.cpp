// Options on a path that trade accuracy for time: substeps and deferred removal.
#include <gtest/gtest.h>

#include <numeric>

#include "kerf/error.h"
#include "support/cuts.h"

namespace kerf {
namespace {

using test::DiscPose;

double Sum(const std::array<double, 256>& by_region) {
  return std::accumulate(by_region.begin(), by_region.end(), 0.0);
}

struct Slot {
  double removed_mm3 = 0;
  double loss_mm3 = 0;
  double mean_thrust_N = 0;
};

/// A kerf 1 mm deep through a block that is skewed in the grid.
Slot CutSlot(const SimulationParams& params) {
  const Pose X_WB = test::BlockPoses(0.1)[5];
  const Vec3 from(-8, 0, 1.5 + 11 - 1), to(8, 0, 1.5 + 11 - 1);
  Simulation simulation(test::MakeBox(X_WB, {12, 2, 3}, 0.1), params, DiscPose(X_WB, from));
  Slot slot;
  const std::vector<TickOutput> ticks = test::Stroke(simulation, X_WB, from, to, 8);
  for (const TickOutput& out : ticks) {
    slot.removed_mm3 += out.removed_mm3;
    slot.mean_thrust_N += out.thrust_sum_N / static_cast<double>(ticks.size());
  }
  slot.loss_mm3 = Sum(simulation.CalcRemovedByRegion());
  return slot;
}

TEST(SimulationAccuracy, DeferredRemovalTakesTheSameBoneAndHardlyChangesTheForce) {
  const Slot each = CutSlot({});
  EXPECT_GT(each.loss_mm3, 2);
  for (const int interval : {2, 3, 64}) {
    SimulationParams params;
    params.carve_interval_ticks = interval;
    const Slot rare = CutSlot(params);
    // The removal rule does not depend on the order of steps; a longer step sweeps one stadium instead of several in a
    // row.
    EXPECT_NEAR(rare.loss_mm3, each.loss_mm3, 1e-5 * each.loss_mm3) << interval;
    // The tool is up to a quarter of a voxel ahead of its cut, which matters at the ends of the arc, 6.6 mm long.
    EXPECT_NEAR(rare.mean_thrust_N, each.mean_thrust_N, 0.02 * each.mean_thrust_N) << interval;
  }
}

TEST(SimulationAccuracy, MoreStepsInATickCutTheSame) {
  const Slot one = CutSlot({});
  SimulationParams params;
  params.substeps = 8;
  const Slot eight = CutSlot(params);
  // The force of a step is the force at its start; the tool moves 8 um in one step, or 1 um in each of eight.
  EXPECT_NEAR(eight.mean_thrust_N, one.mean_thrust_N, 0.01 * one.mean_thrust_N);
  EXPECT_NEAR(eight.loss_mm3, one.loss_mm3, 1e-5 * one.loss_mm3);
}

TEST(SimulationAccuracy, PendingRemovalIsDoneBeforeTheToolIsLifted) {
  const Vec3 above(0, 0, 1.5 + 11 + 0.005);
  std::vector<double> loss_mm3;
  for (const int interval : {1, 64}) {
    SimulationParams params;
    params.carve_interval_ticks = interval;
    Simulation simulation(test::MakeBox(Pose{}, {12, 2, 3}, 0.1), params, DiscPose(Pose{}, above));
    for (int i = 1; i <= 10; ++i) {
      TickInput in;
      in.X_WT = DiscPose(Pose{}, above - Vec3(0, 0, 0.002 * i));
      simulation.Tick(in);
    }
    simulation.SetDown(DiscPose(Pose{}, above + Vec3(0, 0, 20)));
    loss_mm3.push_back(Sum(simulation.CalcRemovedByRegion()));
  }
  EXPECT_GT(loss_mm3[0], 1e-3);
  EXPECT_NEAR(loss_mm3[1], loss_mm3[0], 1e-5 * loss_mm3[0]);
}

TEST(SimulationAccuracy, ValuesOutOfRangeAreNamed) {
  SimulationParams params;
  params.substeps = 0;
  EXPECT_THROW(CutSlot(params), Error);
  params.substeps = 1;
  params.carve_interval_ticks = 65;
  EXPECT_THROW(CutSlot(params), Error);
}

}  // namespace
}  // namespace kerf
