// Lowering the fidelity and raising it again to save time: the force has no step, and all bone is removed in the end.
#include <gtest/gtest.h>

#include <algorithm>

#include "cut/hand_sim/hands.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;

struct Record {
  double largest_step_N = 0;  // largest change of the force from tick to tick while cutting
  double removed_mm3 = 0;
  double slab_removed_mm3 = 0;  // removed while the slab's law is in use
  int slab_ticks = 0;
  int blending_ticks = 0;
  double last_z = 0;
};

/// Moves a handle down at 3 mm/s for 1.5 s, with the fidelity that is requested for each tick.
template <typename Ask>
Record Plunge(const CoupledParams& params, Ask ask) {
  Bone bone = test::MakeBox(Pose{}, {26, 2, 10}, 0.1);
  CoupledSimulation simulation(bone, params, DiscPose(Pose{}, {0, 0, 5 + kR + 0.2}));
  Record run;
  Vec3 last_N(0);
  for (int i = 0; i < 2500; ++i) {
    simulation.SetFidelity(ask(i));
    const double z = 5 + kR + 0.2 - 0.003 * std::min(i, 2000);
    const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, z})));
    if (i > 150) run.largest_step_N = std::max(run.largest_step_N, glm::length(out.f_H_W_N - last_N));
    last_N = out.f_H_W_N;
    run.removed_mm3 += out.removed_mm3;
    run.blending_ticks += (out.status & kCoupledBlending) != 0;
    if (out.fidelity == Fidelity::kSlab) {
      ++run.slab_ticks;
      run.slab_removed_mm3 += out.removed_mm3;
      EXPECT_EQ(out.status & kCoupledBlending, 0u);
    }
    EXPECT_EQ(out.status & (kCoupledIterationsUsedUp | kCoupledSubstepsUsedUp), 0u) << i;
    run.last_z = out.X_WT.p_AB.z;
  }
  return run;
}

TEST(CoupledFidelity, ChangesCauseNoStepInTheForce) {
  const Record full = Plunge(test::DiscParams(), [](int) { return Fidelity::kFull; });
  const Record coarse =
      Plunge(test::DiscParams(), [](int i) { return i % 100 < 50 ? Fidelity::kFull : Fidelity::kCoarse; });
  const Record slab = Plunge(test::DiscParams(), [](int i) {
    return i < 600 ? Fidelity::kFull : i < 700 ? Fidelity::kCoarse : i < 1400 ? Fidelity::kSlab : Fidelity::kFull;
  });
  EXPECT_EQ(full.slab_ticks + coarse.slab_ticks, 0);
  EXPECT_NEAR(slab.slab_ticks, 500, 2);  // 200 of the 700 ticks are transitions
  EXPECT_GE(slab.blending_ticks, 400);   // transitions down and up
  EXPECT_EQ(slab.slab_removed_mm3, 0);
  // The handle stretches the coupling by 3 um, or 3 mN, per tick; no tick changes the force by much more than that.
  EXPECT_LT(full.largest_step_N, 0.0035);
  EXPECT_LT(coarse.largest_step_N, 0.0035);
  EXPECT_LT(slab.largest_step_N, 0.007);
}

TEST(CoupledFidelity, BonePassedByTheSlabLawIsRemovedAfterwards) {
  CoupledParams params = test::DiscParams();
  const Record full = Plunge(params, [](int) { return Fidelity::kFull; });
  const Record slab = Plunge(params, [](int i) { return i < 600 || i > 1400 ? Fidelity::kFull : Fidelity::kSlab; });
  ASSERT_GT(slab.slab_ticks, 300);
  // The removed bone is what the disc covers at its final depth: a segment of the disc times its thickness, to 1 % with
  // voxels of 0.1 mm.
  for (const Record& run : {full, slab}) {
    const double depth = 5 + kR - run.last_z;
    EXPECT_NEAR(run.removed_mm3 / (test::SegmentArea(kR, depth) * kSaw.thickness_mm), 1, 0.015) << depth;
  }
}

TEST(CoupledFidelity, SlabFollowsThePapersLawWithDepth) {
  for (const PaperReading reading : {PaperReading::kCorrected, PaperReading::kAsComputed}) {
    CoupledParams params = test::DiscParams();
    params.slab_reading = reading;
    CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 2, 10}, 0.1), params,
                                 DiscPose(Pose{}, {0, 0, 5 + kR + 0.2}));
    double first_N = 0;
    double first_n = 0;
    int checked = 0;
    double last_z = 0;
    for (int i = 0; i < 4000; ++i) {
      simulation.SetFidelity(i < 600 ? Fidelity::kFull : Fidelity::kSlab);
      const double z = 5 + kR + 0.2 - 0.003 * i;
      const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, z})));
      // Where the tool catches up, faster than 5 mm/s, the force is larger than the law's.
      const bool fast = last_z - out.X_WT.p_AB.z > 0.005;
      last_z = out.X_WT.p_AB.z;
      if (out.fidelity != Fidelity::kSlab || fast || out.X_WT.p_AB.z < kR - 2) continue;
      const double depth = 5 + kR - out.X_WT.p_AB.z;
      const double n = CalcPaperTeeth(kSaw, depth, reading);
      const double shape = reading == PaperReading::kCorrected ? n : n * n * n;
      if (first_N == 0) {
        first_N = out.thrust_sum_N;
        first_n = shape;
        continue;
      }
      // The depth at the start is known from the engaged arc to 1 %. This matters only near depths at which a tooth is
      // added; they are left out.
      const bool at_step = reading == PaperReading::kAsComputed &&
                           (CalcPaperTeeth(kSaw, depth - 0.1, reading) != CalcPaperTeeth(kSaw, depth + 0.1, reading));
      if (at_step || out.thrust_sum_N < 0.1) continue;
      EXPECT_NEAR(out.thrust_sum_N / first_N * first_n / shape, 1, 0.03) << depth;
      ++checked;
    }
    EXPECT_GT(checked, 100);
  }
}

TEST(CoupledFidelity, SlabLawHoldsTheDiscInItsPlaneAndLetsItOut) {
  CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 2, 10}, 0.1), test::DiscParams(),
                               DiscPose(Pose{}, {0, 0, 5 + kR + 0.2}));
  CoupledOutput out;
  double z = 5 + kR + 0.2;
  for (int i = 0; i < 1500; ++i) {
    simulation.SetFidelity(i < 1000 ? Fidelity::kFull : Fidelity::kSlab);
    out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, z -= 0.003})));
  }
  ASSERT_EQ(out.fidelity, Fidelity::kSlab);
  for (int i = 0; i < 100; ++i) out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 4, z})));
  EXPECT_EQ(out.fidelity, Fidelity::kSlab);
  EXPECT_NEAR(out.X_WT.p_AB.y, 0, 0.001);  // 4 N act on three points with 3000 N/mm each
  EXPECT_NEAR(out.f_H_W_N.y, -4, 0.01);
  double max_N = 0;
  for (int i = 0; i < 8000; ++i) {
    out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, z += 0.003})));
    if (z > out.X_WT.p_AB.z + 0.01) max_N = std::max(max_N, -out.f_H_W_N.z);
  }
  EXPECT_LT(max_N, 0.5);  // on the way out, only the friction at creep speed resists
  EXPECT_EQ(out.f_H_W_N, Vec3(0));
  EXPECT_NE(out.fidelity, Fidelity::kSlab);  // outside the bone there is no time to save
}

}  // namespace
}  // namespace kerf
