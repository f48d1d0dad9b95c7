// Hard case 39: the law changes during contact, from the voxel bone to the thin slab and back.
#include <gtest/gtest.h>

#include <algorithm>

#include "cut/hand_sim/hands.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::PushingHand;
using test::Verdict;

const double kFidelitySwitchClear = 5 + kR + 0.2;  // height of the disc's centre just above the block

CoupledSimulation Start(double y_mm = 4) {
  return CoupledSimulation(test::MakeBox(Pose{}, {26, y_mm, 10}, 0.2), test::DiscParams(),
                           DiscPose(Pose{}, {0, 0, kFidelitySwitchClear}));
}

TEST(HardCase39, SwitchingTheLawInContactIsNotFelt) {
  Verdict verdict("holds");
  // The handle moves down at 3 mm/s and across at 0.3 mm/s, like a slightly unsteady hand. The fidelity changes every
  // 50 to 450 ms, sometimes before the previous change is complete.
  CoupledSimulation simulation = Start();
  std::vector<Vec3> f;
  std::uint64_t seed = 1;
  int until = 700;
  Fidelity asked = Fidelity::kFull;
  int switches = 0;
  int slab_ticks = 0;
  for (int i = 0; i < 3000; ++i) {
    if (i >= until) {
      seed = seed * 6364136223846793005U + 1442695040888963407U;
      asked = asked == Fidelity::kSlab ? (seed >> 40) % 3 == 0 ? Fidelity::kCoarse : Fidelity::kFull : Fidelity::kSlab;
      until = i + 50 + static_cast<int>((seed >> 33) % 400);
      ++switches;
    }
    simulation.SetFidelity(asked);
    const CoupledOutput out =
        simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.05 * std::sin(0.006 * i), kFidelitySwitchClear - 0.003 * i})));
    slab_ticks += out.fidelity == Fidelity::kSlab;
    if (i > 200) f.push_back(out.f_H_W_N);
  }
  EXPECT_GE(switches, 6);
  EXPECT_GT(slab_ticks, 200);
  const TickSteps steps = CalcTickSteps(f);
  verdict.AtMost("C2, largest, in JND", steps.max, 1);
  verdict.AtMost("C2, 99.9th percentile, in JND", steps.p999, 0.5);
  verdict.Note("law changes", switches);
}

TEST(HardCase39, ForceRisesOverTheBlendOnReturnToTheBonesLaw) {
  Verdict verdict("holds");
  // A soft coupling hides a change of law, because its force changes by at most K (v_hand - v_tool). With a stiff
  // coupling, and a feed that hardly affects the slab's law but does affect the bone's, the whole change shows.
  CoupledParams params = test::DiscParams();
  params.coupling.stiffness_N_per_mm = 1000;
  CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 4, 10}, 0.2), params,
                               DiscPose(Pose{}, {0, 0, kFidelitySwitchClear}));
  double z = kFidelitySwitchClear;
  CoupledOutput out;
  const auto run = [&](int ticks, double feed_mm_per_s, const auto& each) {
    for (int i = 0; i < ticks; ++i) {
      z -= 1e-3 * feed_mm_per_s;
      const double before = out.f_H_W_N.z;
      out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, z})));
      each(std::abs(out.f_H_W_N.z - before));
    }
  };
  const auto nothing = [](double) {};
  run(600, 1.5, nothing);
  simulation.SetFidelity(Fidelity::kSlab);
  run(400, 1.5, nothing);
  run(300, 5, nothing);
  ASSERT_EQ(out.fidelity, Fidelity::kSlab);
  const double in_slab_N = out.f_H_W_N.z;
  simulation.SetFidelity(Fidelity::kFull);
  double largest_N = 0;
  run(500, 5, [&](double step_N) { largest_N = std::max(largest_N, step_N); });
  const double in_bone_N = out.f_H_W_N.z;
  verdict.Note("force before, slab law", in_slab_N, "N");
  verdict.Note("force after, bone law", in_bone_N, "N");
  ASSERT_GT(std::abs(in_bone_N - in_slab_N), 2);
  // The blend is 3 s^2 - 2 s^3 over 200 ticks, so it changes by at most 1.5 / 200 of the difference per tick.
  verdict.AtMost("largest force step in a tick relative to the change", largest_N / std::abs(in_bone_N - in_slab_N),
                 0.015);
}

TEST(HardCase39, TheSlabsFeedIsBounded) {
  Verdict verdict(
      "holds, corrected: the slab law does not depend on the feed, so its force now grows with the feed above 5 mm/s "
      "or twice the initial feed");
  // The saw cuts with 2 N until slab mode starts, and is then pushed with 3, 6 and 12 times that force.
  double worst = 0;
  for (const double push_N : {6.0, 12.0, 24.0}) {
    CoupledSimulation simulation = Start();
    PushingHand hand(simulation, DiscPose(Pose{}, {0, 0, kFidelitySwitchClear}));
    double z = kFidelitySwitchClear;
    double feed = 0;
    CoupledOutput out;
    int i = 0;
    for (; i < 4000 && (i < 200 || 5 + kR - z < 2); ++i) {
      out = hand.Push({0, 0, -2});
      feed = (z - out.X_WT.p_AB.z) * 1000;
      z = out.X_WT.p_AB.z;
    }
    ASSERT_GT(feed, 0.1);
    simulation.SetFidelity(Fidelity::kSlab);
    for (i = 0; i < 1000 && out.fidelity != Fidelity::kSlab; ++i) {
      out = hand.Push({0, 0, -2});
      z = out.X_WT.p_AB.z;
    }
    ASSERT_EQ(out.fidelity, Fidelity::kSlab);
    double fastest = 0;
    for (i = 0; i < 100; ++i) {
      out = hand.Push({0, 0, -push_N});
      fastest = std::max(fastest, (z - out.X_WT.p_AB.z) * 1000);
      z = out.X_WT.p_AB.z;
    }
    // The resistance is at least 2 N, because the tool has moved deeper. At twice the initial feed, times push / 2 N,
    // it always balances the push.
    const double rated = std::max(5.0, 2 * feed);
    worst = std::max(worst, fastest / (rated * push_N / 2));
    EXPECT_GT(fastest, 0.5 * feed);
  }
  verdict.AtMost("fastest feed relative to its bound", worst, 1.05);
}

TEST(HardCase39, SwitchingTheLawCreatesNoEnergy) {
  Verdict verdict("holds");
  CoupledSimulation simulation = Start();
  double lost_mJ = 0, min_mJ = 0, total_mJ = 0, closes = 0;
  for (int i = 0; i < 2500; ++i) {
    simulation.SetFidelity(i / 170 % 2 == 1 ? Fidelity::kSlab : Fidelity::kFull);
    const CoupledOutput out = simulation.Tick(
        Handle(DiscPose(Pose{}, {0, 0.2 * std::sin(0.02 * i), kFidelitySwitchClear - 3 * (1 - std::cos(0.002 * i))})));
    const double lost = out.cut_mJ + out.friction_mJ + out.damping_mJ + out.numerical_mJ;
    closes = std::max(closes, std::abs(out.hand_mJ + out.spindle_mJ - out.stored_mJ - lost));
    lost_mJ += lost;
    total_mJ += std::abs(out.hand_mJ) + out.spindle_mJ;
    min_mJ = std::min(min_mJ, lost_mJ);
  }
  ASSERT_GT(total_mJ, 1);
  verdict.AtLeast("minimum energy lost since the start", min_mJ, -1e-7 * total_mJ, "mJ");
  verdict.AtMost("error of a tick's energy balance", closes, 1e-9, "mJ");
}

}  // namespace
}  // namespace kerf
