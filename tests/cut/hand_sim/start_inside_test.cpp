// A tool that is set down inside the bone: the bone inside the tool is removed at once, as for a tool on a path.
#include <gtest/gtest.h>

#include <numeric>
#include <utility>

#include "base/core/heap_guard.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "support/solids.h"

namespace kerf {
namespace {

constexpr double kVoxel_mm = 0.2;
const DiscSaw kThickDisc{.diameter_mm = 22, .thickness_mm = 3, .teeth = 24};

struct After {
  double left_mm3 = 0;
  double removed_mm3 = 0;
  std::uint64_t hash = 0;
};

template <typename Simulation>
After Look(Simulation& simulation) {
  const auto by_region = simulation.CalcRemovedByRegion();
  return {simulation.UpdateBone().CalcVolume(), std::accumulate(by_region.begin(), by_region.end(), 0.0),
          simulation.UpdateBone().CalcHash()};
}

/// Returns the state after one tick at rest at X_WT.
After Hold(Bone bone, const Tool& tool, const Pose& X_WT, double rpm = 7500) {
  CoupledParams params;
  params.tool = tool;
  params.effects.clear();
  CoupledSimulation simulation(std::move(bone), params, X_WT);
  {
    const HeapGuard guard;
    simulation.Tick({.X_WH = X_WT, .rpm = rpm});
  }
  return Look(simulation);
}

After Follow(Bone bone, const Tool& tool, const Pose& X_WT) {
  SimulationParams params;
  params.tool = tool;
  params.effects.clear();
  Simulation simulation(std::move(bone), params, X_WT);
  simulation.Tick({.X_WT = X_WT});
  return Look(simulation);
}

Pose Tilted() {
  Pose X;
  X.R_AB = glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, -1)));
  X.p_AB = {0.37, -0.21, 0.11};
  return X;
}

TEST(StartInside, BlockWithinTheDiscIsRemoved) {
  // A block of 6 x 6 x 1 mm fits inside a disc of 22 x 3 mm in the same plane, 1 mm from its flats and 6 mm from its
  // rim.
  const Bone block = test::MakeBox({}, {6, 6, 1}, kVoxel_mm);
  const After after = Hold(block, kThickDisc, {});
  EXPECT_EQ(after.left_mm3, 0);
  EXPECT_NEAR(after.removed_mm3, block.CalcVolume(), 1e-9 * block.CalcVolume());
}

TEST(StartInside, RemovesTheSameBoneAsAToolOnAPath) {
  const Bone block = test::MakeBox({}, {16, 30, 12}, kVoxel_mm);
  for (const Tool& tool : {Tool(kThickDisc), Tool(BallBurr{.diameter_mm = 8})}) {
    const After held = Hold(block, tool, Tilted());
    const After followed = Follow(block, tool, Tilted());
    EXPECT_GT(held.removed_mm3, 200);
    // The tick also moves a hand-held tool by less than a nanometre; multiplied by the tool's surface of less than 1000
    // mm2, this is the tolerance.
    EXPECT_NEAR(held.removed_mm3, followed.removed_mm3, 1e-6 * 1000);
  }
}

TEST(StartInside, StoppedToolRemovesNothing) {
  const Bone block = test::MakeBox({}, {6, 6, 1}, kVoxel_mm);
  const After after = Hold(block, kThickDisc, {}, 0);
  EXPECT_EQ(after.left_mm3, block.CalcVolume());
  EXPECT_EQ(after.removed_mm3, 0);
}

}  // namespace
}  // namespace kerf
