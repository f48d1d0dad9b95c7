// Tests of constants of the tick for which no other test would detect a change by a factor of four. The effect of each
// constant is measured from outside.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bone/grid/field.h"
#include "cut/contact/penetration_limiter.h"
#include "cut/hand_sim/hands.h"
#include "cut/removal/cutter.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::Handle;
using test::PushingHand;

constexpr double kMutantsVoxel = 0.2;

/// Returns a block of 30 x 4 x 8 mm with its top at z = 4.
Bone MakeBlockOfBone(double E_MPa = 19300) {
  Bone bone = test::MakeBox(Pose{}, {30, 4, 8}, kMutantsVoxel);
  bone.set_materials(test::OneRegionTable(24, E_MPa, 0.28));
  return bone;
}

/// A stopped saw, set down too deep in the bone by `depth_mm`. While it is pressed down and rotated about its spindle,
/// it stays in place, and friction dissipates more energy than the reserve can store.
struct RubbedSaw {
  explicit RubbedSaw(double depth_mm)
      : X(DiscPose(Pose{}, {0, 0, 4 + kR - depth_mm})),
        simulation(MakeBlockOfBone(), DiscParams(), X),
        hand(simulation, X) {
    for (int i = 0; i < 60; ++i) {
      hand.R_WH() = glm::angleAxis(0.01 * i, Vec3(0, 1, 0)) * X.R_AB;
      const CoupledOutput out = hand.Push({0, 0, -35}, 0);
      lost_mJ += out.friction_mJ + out.numerical_mJ;
    }
    hand.R_WH() = hand.X_WT().R_AB;
  }
  Pose X;
  CoupledSimulation simulation;
  PushingHand hand;
  double lost_mJ = 0;
};

TEST(Mutants, PushOutHasItsDocumentedSpeed) {
  RubbedSaw saw(1);
  ASSERT_GT(saw.lost_mJ, 10);
  // When the tool is released, it comes out at the allowed speed.
  double z[61];
  for (double& height : z) height = saw.hand.Push({0, 0, -1e-3}, 0).X_WT.p_AB.z;
  ASSERT_LT(z[60], 4 + kR - 0.1);
  const double speed = (z[60] - z[10]) / 0.05;
  EXPECT_NEAR(speed, PenetrationLimiter::kSpeed_mm_per_s, 0.25 * PenetrationLimiter::kSpeed_mm_per_s);
  EXPECT_NEAR(speed, 2, 0.5);  // and that speed is slow
}

TEST(Mutants, PushOutUsesNoMoreEnergyThanWasDissipated) {
  // Nothing was dissipated, so no energy is available.
  CoupledSimulation fresh(MakeBlockOfBone(), DiscParams(), DiscPose(Pose{}, {0, 0, 4 + kR + 0.05}));
  const Pose X = DiscPose(Pose{}, {0, 0, 4 + kR - 0.2});
  ASSERT_TRUE(fresh.SetDown(X));
  PushingHand hand(fresh, X);
  CoupledOutput out;
  for (int i = 0; i < 100; ++i) out = hand.Push({0, 0, -1}, 0);
  EXPECT_LT(out.X_WT.p_AB.z, X.p_AB.z + 1e-3);
}

TEST(Mutants, PushOutUsesNoMoreEnergyThanTheReserve) {
  // Much energy was dissipated, but the reserve is limited: 5 mJ lift a tool that is pressed down with 10 N by 0.5 mm.
  RubbedSaw saw(3);
  ASSERT_GT(saw.lost_mJ, 20);
  const double z = saw.hand.X_WT().p_AB.z;
  CoupledOutput out;
  for (int i = 0; i < 2000; ++i) out = saw.hand.Push({0, 0, -10}, 0);
  const double lifted_mJ = 10 * (out.X_WT.p_AB.z - z);
  EXPECT_GT(lifted_mJ, 2.5);
  EXPECT_LT(lifted_mJ, 10);
}

TEST(Mutants, StoppedEdgeYieldsByItsStiffness) {
  CoupledSimulation simulation(MakeBlockOfBone(), DiscParams(), DiscPose(Pose{}, {0, 0, 4 + kR + 0.05}));
  PushingHand hand(simulation, DiscPose(Pose{}, {0, 0, 4 + kR + 0.05}));
  CoupledOutput out;
  const double push_N = 20;
  for (int i = 0; i < 400; ++i) out = hand.Push({0, 0, -push_N}, 0);
  // One of the points is the lowest. Each point is a spring of 2000 N/mm per eighth of a pitch.
  const int samples = DiscParams().rim_samples_per_pitch;
  const double depth = 4 + kR - out.X_WT.p_AB.z;
  double force_N = 0;
  for (int k = -40; k <= 40; ++k) {
    const double angle = 2 * std::numbers::pi * k / (samples * kSaw.teeth);
    force_N += 2000 * 8.0 / samples * std::max(0.0, depth - kR * (1 - std::cos(angle))) * std::cos(angle);
  }
  EXPECT_NEAR(force_N / push_N, 1, 0.1) << depth;
}

TEST(Mutants, SubstepsAreHalfAVoxelAcrossTheSpindle) {
  // The bone has hardly any resistance, and a stiff coupling moves the tool by 0.45 mm per tick.
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = 1000;
  params.coupling.max_force_N = 1e4;
  params.law = ForceLaw("hertz_chip");  // depends on E
  CoupledSimulation simulation(MakeBlockOfBone(0.01), params, DiscPose(Pose{}, {0, 0, 4 + kR + 0.05}));
  double z = 4 + kR + 0.05;
  for (int i = 0; i < 40; ++i) {
    const double before = z;
    const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 4 + kR + 0.05 - 0.05 * i})));
    z = out.X_WT.p_AB.z;
    if (i > 5) {
      EXPECT_LE(out.substeps, 1 + (before - z) / (0.5 * kMutantsVoxel));
    }
  }
  for (int i = 1; i <= 4; ++i) {
    const double before = z;
    const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 4 + kR + 0.05 - 0.05 * 39 - 0.45 * i})));
    z = out.X_WT.p_AB.z;
    EXPECT_NEAR(before - z, 0.45, 0.01);
    EXPECT_GE(out.substeps, 4);
    EXPECT_LE(out.substeps, 6);
  }
}

TEST(Mutants, SubstepsAreAQuarterOfALayerAlongTheSpindle) {
  // The disc is too shallow for its flats to touch and moves along the spindle by 0.19 mm per tick. The substeps are
  // quarters of the voxel's 0.2 mm, because the disc is 0.25 mm thick.
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = 1000;
  params.coupling.max_force_N = 1e4;
  params.law = ForceLaw("hertz_chip");  // depends on E
  CoupledSimulation simulation(MakeBlockOfBone(0.01), params, DiscPose(Pose{}, {0, 0, 4 + kR + 0.05}));
  const double z = 4 + kR - 0.3;
  CoupledOutput out;
  for (int i = 0; i <= 60; ++i) out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, 4 + kR + 0.05 - 0.35 * i / 60})));
  double y = out.X_WT.p_AB.y;
  for (int i = 1; i <= 4; ++i) {
    const double before = y;
    out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.19 * i, z})));
    y = out.X_WT.p_AB.y;
    EXPECT_NEAR(y - before, 0.19, 0.02);
    EXPECT_GE(out.substeps, 3);
    EXPECT_LE(out.substeps, 5);
  }
}

TEST(Mutants, TeethTouchTheBoneAtItsSurface) {
  // A rim that comes down on flat bone engages teeth in the first tick that begins with the rim where teeth begin to
  // enter: half of kEntryVoxels in front of the surface.
  constexpr double kBegin_mm = 0.5 * 0.15 * kMutantsVoxel;
  constexpr double kStep_mm = 0.01 * kMutantsVoxel;
  const auto pose = [](double gap_mm) { return DiscPose(Pose{}, {0, 0, 4 + kR + gap_mm}); };
  CoupledSimulation simulation(MakeBlockOfBone(), DiscParams(), pose(0.3 * kMutantsVoxel));
  double before_mm = 0.3 * kMutantsVoxel, gap_mm = before_mm;
  CoupledOutput out;
  for (int i = 0; i < 60 && out.engaged_teeth == 0; ++i) {
    before_mm = gap_mm;
    out = simulation.Tick(Handle(pose(0.3 * kMutantsVoxel - kStep_mm * (i + 1))));
    gap_mm = out.X_WT.p_AB.z - 4 - kR;
  }
  EXPECT_GT(out.engaged_teeth, 0);
  EXPECT_LE(before_mm, kBegin_mm);
  EXPECT_GE(before_mm, kBegin_mm - 1.1 * kStep_mm);
}

TEST(Mutants, AListOfLeavesIsNotUsedForACutThatBeginsBeyondIt) {
  // A list made near one place is valid within its slack. A long cut that begins outside that range and ends inside it
  // must not use the list: the bone must be the one that a cutter without a list would leave.
  constexpr double h = 0.1;
  const Bone bone = test::MakeBox(Pose{}, {40, 3, 20}, h);
  const auto cut_without_list = [&](const Pose& a, const Pose& b, const Pose& c) {
    Bone copy = bone;
    BoneField field(copy);
    Cutter(field, kSaw, CutWith::kEdge).Cut(a, a);
    Cutter(field, kSaw, CutWith::kEdge).Cut(b, c);
    field.Settle();
    return copy.CalcHash();
  };
  for (int n = 0; n < 9; ++n) {
    const double x = -4 + 0.1 * n;
    const Pose first = DiscPose(Pose{}, {x, 0, 14});
    // The slack is 1 mm, and the motion is a quarter of that.
    const Pose from = DiscPose(Pose{}, {x + 1.19, 0, 14});
    const Pose to = DiscPose(Pose{}, {x + 0.94, 0, 14});
    Bone copy = bone;
    BoneField field(copy);
    Cutter cutter(field, kSaw, CutWith::kEdge);
    cutter.Cut(first, first);
    cutter.Lift();
    cutter.Cut(from, to);
    field.Settle();
    EXPECT_EQ(copy.CalcHash(), cut_without_list(first, from, to)) << n;
  }
}

}  // namespace
}  // namespace kerf
