// Without spare leaves, the tool waits at uncut bone, and continues after Refill().
#include <gtest/gtest.h>

#include <thread>

#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "support/solids.h"

namespace kerf {
namespace {

TEST(CoupledLeaves, ToolWaitsBeforeUncutBoneAndGoesOnAfterRefill) {
  // The disc is lowered edge on into a block that is pure bone inside; the leaves at the block's surface have their own
  // voxels.
  const Quat R = glm::angleAxis(1.5707963267948966, Vec3(1, 0, 0));
  const auto handle = [&](int tick) { return Pose{R, Vec3(0, 0, 12 - std::min(0.004 * tick, 7.0))}; };
  CoupledParams params;
  params.spare_leaves = 0;
  CoupledSimulation simulation(test::MakeBox({{1, 0, 0, 0}, Vec3(0, 0, -5)}, {14, 8, 10}, 0.1), params, handle(0));
  const double before = simulation.UpdateBone().CalcVolume();
  int waited = 0;
  double removed = 0;
  CoupledOutput out;
  for (int i = 1; i <= 4000; ++i) {
    out = simulation.Tick({.X_WH = handle(i)});
    ASSERT_TRUE(std::isfinite(out.f_H_W_N.z));
    ASSERT_LE(glm::length(out.f_H_W_N), params.coupling.max_force_N * (1 + 1e-9));
    waited += (out.status & kCoupledLeavesUsedUp) != 0 ? 1 : 0;
    removed += out.removed_mm3;
  }
  EXPECT_GT(waited, 100);
  // The disc stops where the leaves of the surface end, at a depth of at most two leaves plus the rim's motion. All
  // bone that its disc has swept is removed: the rim has not passed through bone.
  const double depth = 11 - out.X_WT.p_AB.z;
  EXPECT_LT(depth, 2 * 0.8 + 0.1);
  const Bone& bone = simulation.UpdateBone();
  for (double x = -2; x <= 2; x += 0.25) {
    EXPECT_GT(bone.SignedDistance({x, 0, out.X_WT.p_AB.z - std::sqrt(121 - x * x) + 0.05}), -0.02) << x;
  }
  // The account of removed volume still matches the bone.
  double exact = 0;
  for (const double mm3 : simulation.CalcRemovedByRegion()) exact += mm3;
  EXPECT_NEAR(exact, before - bone.CalcVolume(), 1e-9 * before);
  EXPECT_NEAR(removed, exact, 0.03 * exact);  // by occupancy, in a cut that ends within the grid
}

TEST(CoupledLeaves, RefillLetsItGoOn) {
  const Quat R = glm::angleAxis(1.5707963267948966, Vec3(1, 0, 0));
  const auto handle = [&](int tick) { return Pose{R, Vec3(0, 0, 12 - std::min(0.004 * tick, 7.0))}; };
  CoupledParams params;
  params.spare_leaves = 60;
  CoupledSimulation simulation(test::MakeBox({{1, 0, 0, 0}, Vec3(0, 0, -5)}, {14, 8, 10}, 0.1), params, handle(0));
  params.spare_leaves = 4096;
  CoupledSimulation enough(test::MakeBox({{1, 0, 0, 0}, Vec3(0, 0, -5)}, {14, 8, 10}, 0.1), params, handle(0));
  for (int i = 1; i <= 2500; ++i) {
    if (i % 20 == 0) simulation.Refill();
    const CoupledOutput out = simulation.Tick({.X_WH = handle(i)});
    ASSERT_EQ(out.status & kCoupledLeavesUsedUp, 0u) << i;
    ASSERT_EQ(out.X_WT.p_AB, enough.Tick({.X_WH = handle(i)}).X_WT.p_AB) << i;
  }
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), enough.UpdateBone().CalcHash());
}

TEST(CoupledLeaves, AnotherThreadSuppliesThemDuringTheTicks) {
  const Quat R = glm::angleAxis(1.5707963267948966, Vec3(1, 0, 0));
  const auto handle = [&](int tick) { return Pose{R, Vec3(0, 0, 12 - std::min(0.004 * tick, 7.0))}; };
  const auto block = [] { return test::MakeBox({{1, 0, 0, 0}, Vec3(0, 0, -5)}, {14, 8, 10}, 0.1); };
  CoupledParams params;
  params.spare_leaves = 4096;
  CoupledSimulation enough(block(), params, handle(0));
  params.spare_leaves = 60;
  CoupledSimulation simulation(block(), params, handle(0));
  const std::jthread supplier([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) SupplyLeaves(simulation);
  });
  for (int i = 1; i <= 2500; ++i) {
    while (CoupledInternals::Work(simulation).spare_leaves < 60) std::this_thread::yield();
    const CoupledOutput out = simulation.Tick({.X_WH = handle(i)});
    ASSERT_EQ(out.status & kCoupledLeavesUsedUp, 0u) << i;
    ASSERT_EQ(out.X_WT.p_AB, enough.Tick({.X_WH = handle(i)}).X_WT.p_AB) << i;
  }
  EXPECT_EQ(simulation.UpdateBone().CalcHash(), enough.UpdateBone().CalcHash());
}

}  // namespace
}  // namespace kerf
