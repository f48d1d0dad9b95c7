// Hard case 39: the law is changed while the tool is in contact: looked-up bone to the thin slab and back.
#include <gtest/gtest.h>

#include <algorithm>

#include "cut/hand_sim/hands.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::PushingHand;
using test::Verdict;

const DiscSaw kSaw;
const double kR = kSaw.radius_mm();
const double kClear = 5 + kR + 0.2;  // height of the disc's centre just above the block

CoupledSimulation Start(double y_mm = 4) {
  return CoupledSimulation(test::MakeBox(Pose{}, {26, y_mm, 10}, 0.2), test::DiscParams(),
                           DiscPose(Pose{}, {0, 0, kClear}));
}

TEST(HardCase39, SwitchingTheLawInContactIsNotFelt) {
  Verdict verdict("holds");
  // A handle that goes down at 3 mm/s and across at 0.3, as a hand that is not quite steady, and the fidelity changed
  // every 50 to 450 ms, also before the last change is done.
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
        simulation.Tick(Handle(DiscPose(Pose{}, {0, 0.05 * std::sin(0.006 * i), kClear - 0.003 * i})));
    slab_ticks += out.fidelity == Fidelity::kSlab;
    if (i > 200) f.push_back(out.f_H_W_N);
  }
  EXPECT_GE(switches, 6);
  EXPECT_GT(slab_ticks, 200);
  const TickSteps steps = CalcTickSteps(f);
  verdict.AtMost("C2, largest, just-noticeable differences", steps.max, 1);
  verdict.AtMost("C2, 99.9th percentile", steps.p999, 0.5);
  verdict.Note("changes of law", switches);
}

TEST(HardCase39, BackInTheBonesLawTheForceRisesOverTheBlend) {
  Verdict verdict("holds");
  // A soft coupling hides a change of law: its force goes by K (v_hand - v_tool) at most. Through a stiff one, and with
  // a feed that the slab's law hardly feels and the bone's does, the whole change is seen.
  CoupledParams params = test::DiscParams();
  params.coupling.stiffness_N_per_mm = 1000;
  CoupledSimulation simulation(test::MakeBox(Pose{}, {26, 4, 10}, 0.2), params, DiscPose(Pose{}, {0, 0, kClear}));
  double z = kClear;
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
  verdict.Note("force before, in the slab's law", in_slab_N, "N");
  verdict.Note("force after, in the bone's", in_bone_N, "N");
  ASSERT_GT(std::abs(in_bone_N - in_slab_N), 2);
  // The blend is 3 s^2 - 2 s^3 over 200 ticks: at its steepest 1.5 / 200 of the change a tick.
  verdict.AtMost("largest step in a tick, of the change", largest_N / std::abs(in_bone_N - in_slab_N), 0.015);
}

TEST(HardCase39, TheSlabsFeedIsBounded) {
  Verdict verdict(
      "holds, mended: the slab's law has no feed, so its force now grows with it from 5 mm/s or twice that at the "
      "start");
  // Cutting with 2 N until the slab takes over, then pushed with 3, 6 and 12 times as much.
  double worst = 0;
  for (const double push_N : {6.0, 12.0, 24.0}) {
    CoupledSimulation simulation = Start();
    PushingHand hand(simulation, DiscPose(Pose{}, {0, 0, kClear}));
    double z = kClear;
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
    // The resistance is 2 N and more, since it went on deeper: at twice the feed of the start times push / 2 N it holds
    // the push, whatever comes.
    const double rated = std::max(5.0, 2 * feed);
    worst = std::max(worst, fastest / (rated * push_N / 2));
    EXPECT_GT(fastest, 0.5 * feed);
  }
  verdict.AtMost("fastest feed, of the bound", worst, 1.05);
}

TEST(HardCase39, EnergyIsNotMadeByTheChange) {
  Verdict verdict("holds");
  CoupledSimulation simulation = Start();
  double lost_mJ = 0, least_mJ = 0, total_mJ = 0, closes = 0;
  for (int i = 0; i < 2500; ++i) {
    simulation.SetFidelity(i / 170 % 2 == 1 ? Fidelity::kSlab : Fidelity::kFull);
    const CoupledOutput out = simulation.Tick(
        Handle(DiscPose(Pose{}, {0, 0.2 * std::sin(0.02 * i), kClear - 3 * (1 - std::cos(0.002 * i))})));
    const double lost = out.cut_mJ + out.friction_mJ + out.damping_mJ + out.numerical_mJ;
    closes = std::max(closes, std::abs(out.hand_mJ + out.spindle_mJ - out.stored_mJ - lost));
    lost_mJ += lost;
    total_mJ += std::abs(out.hand_mJ) + out.spindle_mJ;
    least_mJ = std::min(least_mJ, lost_mJ);
  }
  ASSERT_GT(total_mJ, 1);
  verdict.AtLeast("energy lost since the start, least", least_mJ, -1e-7 * total_mJ, "mJ");
  verdict.AtMost("account of a tick open by", closes, 1e-9, "mJ");
}

}  // namespace
}  // namespace kerf
