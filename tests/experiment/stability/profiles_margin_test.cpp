// Margins of the defaults: every device of the table with every hand, with its coupling as `kerf loop` fits it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "experiment/stability/held_tool.h"
#include "experiment/stability/scenarios.h"
#include "held_block.h"
#include "verdict.h"

namespace kerf {
namespace {

using test::Verdict;

StabilitySubject MakeMarginSubject() {
  StabilitySubject subject;
  subject.bone = test::BlockOfBone(0.2, Vec3(26, 4, 12));
  subject.setup.coupled.spare_leaves = 1000;
  subject.X_WT_start = test::OverBlock();
  return subject;
}

class ProfileMargin : public testing::TestWithParam<HeldState> {};

// Friction and encoder steps, which can only damp, are left out. This is the strict interpretation of the requirement.
TEST_P(ProfileMargin, IsAtLeastAGainOfTwoAndATickOfDelayForEveryHand) {
  Verdict verdict("holds");
  const StabilitySubject subject = MakeMarginSubject();
  const HeldTool held = HoldTool(subject, GetParam());
  double worst_gain = -1e300;
  double worst_delay = -1e300;
  int tried = 0;
  for (const DeviceProfile& profile : DeviceProfiles()) {
    for (const HandModel& hand : HandModels()) {
      ClosedLoopSetup setup = FitSetup(subject.setup, profile, hand, hand);
      setup.loop_gain = 2;
      const double gain = FindGrowth(held, setup).value();
      EXPECT_LT(gain, 0) << profile.name << " " << hand.name << " at twice the gain";
      setup.loop_gain = 1;
      setup.delay_ticks = 1;
      const double delay = FindGrowth(held, setup).value();
      EXPECT_LT(delay, 0) << profile.name << " " << hand.name << " with a tick of delay";
      worst_gain = std::max(worst_gain, gain);
      worst_delay = std::max(worst_delay, delay);
      ++tried;
    }
  }
  verdict.Note("combinations of device and hand", tried);
  verdict.AtMost("growth rate at twice the gain, worst", worst_gain, 0, "1/s");
  verdict.AtMost("growth rate with a tick of delay, worst", worst_delay, 0, "1/s");
}

INSTANTIATE_TEST_SUITE_P(States, ProfileMargin, testing::ValuesIn(kHeldStates), [](const auto& tested) {
  std::string name;
  for (const char c : std::string(ToString(tested.param))) {
    if (c != ' ') name += c;
  }
  return name;
});

// Far below the limit, the damping of hand and device decides how fast a kick decays, not the gain. In a kerf, contacts
// that open and close put dents into the swings, at some gains as large as the last swings.
TEST(KickInTheKerf, DecaysAlikeAtEveryGain) {
  Verdict verdict("holds");
  const StabilitySubject subject = MakeMarginSubject();
  const HeldTool held = HoldTool(subject, HeldState::kInKerf);
  const HandModel& hand = FindHandModel("H4");
  ClosedLoopSetup setup = FitSetup(subject.setup, FindDeviceProfile("virtuose_6d"), hand, hand);
  const double nominal = FindGrowth(held, setup).value();
  double worst = 0;
  for (const double gain : {1.5, 1.9, 1.95, 2.0, 2.05, 2.1, 2.5, 4.0}) {
    setup.loop_gain = gain;
    worst = std::max(worst, std::abs(FindGrowth(held, setup).value() / nominal - 1));
  }
  EXPECT_LT(nominal, -5);
  verdict.AtMost("change of the growth rate between gains of 1 and 4", 100 * worst, 8, "%");
}

// Tests light devices and stiff hands at the lowest and the highest rate. The damper, whose velocity is eight ticks
// late, must not use up the stiffness's margin. At 250 Hz the largest damping that a scene allows is also tested.
TEST(RateMargin, IsAtLeastAGainOfTwoAndATickOfDelayFrom250To4000Hz) {
  Verdict verdict("holds");
  double worst = -1e300;
  for (const double rate_hz : {250.0, 4000.0}) {
    StabilitySubject subject = MakeMarginSubject();
    subject.setup.period_s = 1 / rate_hz;
    const HeldTool held = HoldTool(subject, HeldState::kStoppedOnBone);
    for (const char* profile : {"ideal", "touch", "omega_6", "maglev_200"}) {
      for (const char* hand : {"H1", "H3", "H4"}) {
        // The damping is not tested at 4000 Hz: a maglev_200 in H1 accepts 0.1 N s/mm there, but is unstable at twice
        // the gain.
        for (const double damping : {0.0, rate_hz < 1000 ? 1.0 : 0.0}) {
          subject.setup.coupled.coupling.stiffness_N_per_mm = 100;
          subject.setup.coupled.coupling.damping_Ns_per_mm = damping;
          ClosedLoopSetup setup =
              FitSetup(subject.setup, FindDeviceProfile(profile), FindHandModel(hand), FindHandModel(hand));
          setup.loop_gain = 2;
          const double gain = FindGrowth(held, setup).value();
          setup.loop_gain = 1;
          setup.delay_ticks = 1;
          const double delay = FindGrowth(held, setup).value();
          EXPECT_LT(gain, 0) << profile << " " << hand << " at twice the gain, " << rate_hz << " Hz, B " << damping;
          EXPECT_LT(delay, 0) << profile << " " << hand << " with a tick, " << rate_hz << " Hz, B " << damping;
          worst = std::max({worst, gain, delay});
        }
      }
    }
  }
  verdict.AtMost("growth rate at twice the gain or with a tick of delay, worst", worst, 0, "1/s");
}

// The coupling is fitted to the hand of the scene, and then the device is released. (With a hand that leans on the
// device without holding it, half of the profiles, which have almost no damping of their own, would have a delay margin
// below one tick. That is not a realistic case.) The spring's energy pushes the handle off the bone once, no harder
// than it was held, and friction and damping dissipate it.
TEST(ReleasedDevice, IsPushedOffTheBoneOnceAndNoHarderThanItWasHeld) {
  Verdict verdict("holds; pushed without being held, half of the devices would tolerate no further tick of delay");
  const auto& all = Scenarios();
  const auto let_go =
      std::find_if(all.begin(), all.end(), [](const Scenario& s) { return s.name == std::string("let_go"); });
  ASSERT_NE(let_go, all.end());
  const StabilitySubject subject = MakeMarginSubject();
  double max_force = -100;
  double max_speed = 0;
  for (const DeviceProfile& profile : DeviceProfiles()) {
    StabilitySubject held = subject;
    held.setup = FitSetup(subject.setup, profile, FindHandModel("H3"), FindHandModel("H3"));
    const ScenarioResult result = let_go->run(held, 1);
    for (const StabilityFigure& f : result.figures) {
      EXPECT_TRUE(f.holds()) << profile.name << ": " << f.name << " " << f.value << " against " << f.bound;
      if (f.name == "rise of the force after the release") max_force = std::max(max_force, f.value);
      if (f.name == "speed of the released handle") max_speed = std::max(max_speed, f.value / f.bound);
    }
  }
  EXPECT_GT(max_force, -100);  // it was measured
  EXPECT_GT(max_speed, 0);
  verdict.AtMost("rise of the force after release, worst", max_force, 5, "%");
  verdict.AtMost("speed relative to that from the spring's energy, worst", max_speed, 1);
}

// In a kerf the walls also hold the tool against rotation, and the loop is a sampled torsion spring on a hand without
// inertia. The limit is exactly k (1 + a) / (1 - a) with a = exp(-k T / c), which is 2 c / T to within a thousandth.
// H1's 5 N mm s allow 10000 N mm/rad at 1 kHz. The 5000 that a scene requests would leave a gain margin of exactly 2;
// the device gets 3000.
TEST(TorsionMargin, MatchesTheRuleForASampledSpring) {
  Verdict verdict("holds");
  const StabilitySubject subject = MakeMarginSubject();
  const HeldTool held = HoldTool(subject, HeldState::kInKerf);
  const HandModel& hand = FindHandModel("H1");
  ClosedLoopSetup setup = FitSetup(subject.setup, FindDeviceProfile("virtuose_6d"), hand, hand);
  ASSERT_EQ(ForceMap(setup.profile, setup.force_map).torque_scale(), 1);
  const double stays = std::exp(-hand.torsion_Nmm_per_rad * setup.period_s / hand.torsion_damping_Nmms);
  const double held_Nmm_per_rad = hand.torsion_Nmm_per_rad * (1 + stays) / (1 - stays);
  const Margins fitted = FindHeldMargins(held, setup, true);
  verdict.AtMost("deviation of the torsional gain margin from the rule, as fitted",
                 100 * std::abs(fitted.gain * setup.coupled.coupling.torsion_Nmm_per_rad / held_Nmm_per_rad - 1), 3,
                 "%");
  EXPECT_GE(fitted.delay_ticks, 1);
  setup.coupled.coupling.torsion_Nmm_per_rad = 5000;
  const Margins asked = FindHeldMargins(held, setup, true);
  verdict.AtMost("deviation of the torsional gain margin from the rule, as requested",
                 100 * std::abs(asked.gain * 5000 / held_Nmm_per_rad - 1), 3, "%");
}

}  // namespace
}  // namespace kerf
