// A saw in a hand, and on a path, at metal.
#include <gtest/gtest.h>

#include "hands.h"
#include "kerf/simulation.h"
#include "support/saw.h"
#include "support/solids.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;

constexpr double kPlatedVoxel_mm = 0.2;

/// A block of 10 x 3 x 6 mm, centred at the origin, that is metal below z = 1.
Bone MakePlated(Tissue below) {
  SolidField solid;
  solid.value = [](const Vec3& p) { return test::BoxDistance(p, Vec3(5, 1.5, 3)); };
  solid.classify = ClassifyByDistance(solid.value);
  solid.region = [](const Vec3& p) { return p.z < 1 ? 35 : 24; };
  MaterialTable table = test::OneRegionTable();
  table.Add({.id = 35, .name = "below", .tissue = below, .E_MPa = 110'000, .nu = 0.34, .source = "test"});
  return MakeBone(solid, Box3{Vec3(-7, -4, -5), Vec3(7, 4, 5)}, {kPlatedVoxel_mm, kPlatedVoxel_mm, {}}, table);
}

TEST(CoupledMetal, HoldsATurningSawAndIsReported) {
  CoupledSimulation simulation(MakePlated(Tissue::kMetal), DiscParams(), DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
  CoupledOutput out;
  double deepest_mm = 10, removed_late_mm3 = 0;
  bool reported_early = false, reported_always = true;
  // The hand goes down at 2 mm/s to 1.5 mm below the metal's surface, and stays there.
  for (int i = 0; i < 4000; ++i) {
    out = simulation.Tick(test::Handle(DiscPose(Pose{}, {0, 0, kR + std::max(3.1 - 0.002 * i, -0.5)})));
    const double rim_mm = out.X_WT.p_AB.z - kR;
    const bool reported = (out.status & kCoupledTouchesMetal) != 0;
    deepest_mm = std::min(deepest_mm, rim_mm);
    reported_early |= rim_mm > 0.9 + 1.1 * kPlatedVoxel_mm && reported;
    reported_always &= i < 3000 || reported;
    if (i >= 3000) removed_late_mm3 += out.removed_mm3;
  }
  // It has cut through the bone above, up to a voxel. The metal ends at the border of its voxels, z = 0.9.
  EXPECT_LT(deepest_mm, 0.9 + 1.1 * kPlatedVoxel_mm);
  EXPECT_GT(deepest_mm, 0.9 - 0.1 * kPlatedVoxel_mm);
  EXPECT_TRUE(reported_always);
  EXPECT_FALSE(reported_early);
  EXPECT_LT(removed_late_mm3, 0.01);
  EXPECT_GT(out.f_H_W_N.z, 1);
  EXPECT_LT(glm::length(out.X_WT.p_AB - Vec3(0, 0, out.X_WT.p_AB.z)), kPlatedVoxel_mm);
}

TEST(PathMetal, IsLeftAndReported) {
  for (const Tissue below : {Tissue::kMetal, Tissue::kCortical}) {
    const bool metal = below == Tissue::kMetal;
    SimulationParams params;
    params.tool = DiscSaw{};
    Simulation simulation(MakePlated(below), params, DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
    std::uint32_t status = 0;
    double last_N = 0;
    for (const TickOutput& out : test::Stroke(simulation, Pose{}, {0, 0, 3 + kR + 0.1}, {0, 0, kR - 1}, 2)) {
      status |= out.status;
      last_N = out.thrust_sum_N;
      EXPECT_TRUE(std::isfinite(out.f_T_W_N.z));
    }
    EXPECT_EQ(status, metal ? kTickTouchesMetal : kTickOk);
    const Bone& after = simulation.UpdateBone();
    EXPECT_EQ(after.SignedDistance({0, 0, 0}) < 0, metal);
    EXPECT_GT(after.SignedDistance({0, 0, 2}), 0);
    EXPECT_GE(last_N, 0);
  }
}

}  // namespace
}  // namespace kerf
