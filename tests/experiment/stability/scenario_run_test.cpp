// Tests of a scenario's checks and measurements, and that it contains the faults that its name announces.
#include "experiment/stability/scenario_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "experiment/stability/held_block.h"

namespace kerf {
namespace {

constexpr double kScenarioRunNaN = std::numeric_limits<double>::quiet_NaN();
const Scenario kTried{"tried", "A scenario.", {}};

StabilitySubject MakeRunSubject(const char* profile = "omega_6", const char* hand = "H3") {
  StabilitySubject subject;
  subject.bone = test::BlockOfBone(0.2);
  subject.setup = test::HeldBlock(profile, hand);
  subject.X_WT_start = test::OverBlock();
  return subject;
}

const Scenario& FindScenario(const std::string& name) {
  for (const Scenario& s : Scenarios()) {
    if (s.name == name) return s;
  }
  throw std::runtime_error("no scenario " + name);
}

/// Returns the figure with this name. Fails the test if there is none.
StabilityFigure Figure(const ScenarioResult& result, const std::string& name) {
  for (const StabilityFigure& f : result.figures) {
    if (f.name == name) return f;
  }
  ADD_FAILURE() << result.name << " has no figure \"" << name << "\"";
  return {};
}

/// Runs a scenario of ten ticks high above the block, with the last tick changed.
ScenarioResult RunWith(const std::function<void(ClosedLoopTick&)>& change) {
  StabilitySubject subject = MakeRunSubject();
  subject.X_WT_start = test::OverBlock(1);  // no bone is near
  // The coupling has damping, like every coupling fitted to a device. The damping must not hide a force.
  EXPECT_GT(subject.setup.coupled.coupling.damping_Ns_per_mm, 0);
  ScenarioRun run(subject, kTried);
  for (int i = 0; i < 9; ++i) run.Step();
  ClosedLoopTick tick = run.loop().Step();
  EXPECT_NE(tick.out.coupled.status & kCoupledAsleep, 0U);
  change(tick);
  run.Take(tick);
  return run.Finish();
}

TEST(ScenarioRun, AcceptsTheUnmodifiedLoop) {
  EXPECT_TRUE(RunWith([](auto&) {}).holds());
}

TEST(ScenarioRun, CountsAForceInTheAir) {
  const ScenarioResult result = RunWith([](ClosedLoopTick& tick) { tick.out.coupled.f_H_W_N.x = 1e-9; });
  EXPECT_EQ(Figure(result, "force in air").value, 1e-9);
  EXPECT_FALSE(Figure(result, "force in air").holds());
}

TEST(ScenarioRun, CountsTicksWithValuesThatAreNotFinite) {
  const std::function<void(ClosedLoopTick&)> changes[] = {
      [](auto& t) { t.f_device_N.z = kScenarioRunNaN; }, [](auto& t) { t.out.coupled.f_H_W_N.z = kScenarioRunNaN; },
      [](auto& t) { t.out.coupled.X_WT.p_AB.z = HUGE_VAL; },
      [](auto& t) { t.out.force.tau_H_W_Nmm.x = kScenarioRunNaN; }, [](auto& t) { t.p_WC_mm.y = -HUGE_VAL; }};
  for (const auto& change : changes) {
    const ScenarioResult result = RunWith(change);
    EXPECT_EQ(Figure(result, "values that are not finite").value, 1) << &change - changes;
    EXPECT_FALSE(result.holds());
  }
}

TEST(ScenarioRun, CountsForcesStepsAndTorquesBeyondTheDevice) {
  EXPECT_FALSE(Figure(RunWith([](auto& t) { t.f_device_N.x = 12.001; }), "largest force").holds());
  // The slew rate is 12 N in 5 ms.
  EXPECT_FALSE(Figure(RunWith([](auto& t) { t.f_device_N.x = 2.401; }), "largest force step in a tick").holds());
  EXPECT_TRUE(Figure(RunWith([](auto& t) { t.f_device_N.x = 2.399; }), "largest force step in a tick").holds());
  EXPECT_FALSE(Figure(RunWith([](auto& t) { t.out.force.tau_H_W_Nmm.x = 1; }), "largest torque").holds());
}

// The energy that may be returned is that of a held force plus a thousandth of the exchanged energy.
TEST(ScenarioRun, AllowsTheEnergyOfAHeldForce) {
  const StabilitySubject subject = MakeRunSubject();
  ScenarioRun run(subject, kTried);
  for (const double exchanged_mJ : {0.1, 20.0}) {
    ClosedLoopTick tick = run.loop().Step();
    tick.energy.held_mJ = 0.25;
    tick.energy.exchanged_mJ = exchanged_mJ;
    const double allowed_mJ = 0.25 + std::max(1e-3, 1e-3 * exchanged_mJ);
    tick.energy.lowest_mJ = -1.01 * allowed_mJ;
    run.Take(tick);
    run.AddEnergy();
    tick.energy.lowest_mJ = -0.99 * allowed_mJ;
    run.Take(tick);
    run.AddEnergy();
  }
  const ScenarioResult result = run.Finish();
  ASSERT_GE(result.figures.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(result.figures[i].holds(), i % 2 == 1) << i;
}

// The disc's radius is 11 mm, and the block's top is at 0. The tolerance covers the 180 points around the rim, 2 um;
// the grid's interpolation of a plane is exact.
TEST(CalcBuried, IsTheDepthOfTheEdge) {
  const Bone bone = test::BlockOfBone(0.2);
  for (const double depth_mm : {-0.4, -0.1, 0.05, 0.2, 0.5}) {
    EXPECT_NEAR(CalcBuried(bone, DiscSaw{}, test::OverBlock(-depth_mm)), depth_mm, 0.005);
    EXPECT_NEAR(CalcBuried(bone, BallBurr{}, test::Upright(Vec3(0, 0, 3 - depth_mm))), depth_mm, 0.03);
  }
}

// A push of 5 N on a plate of 3 mm: the tool breaks through in the available time, and the intervals before and after
// are measured.
TEST(ScenarioFaults, BreakThroughCutsThroughAThinPlate) {
  StabilitySubject subject = MakeRunSubject();
  subject.bone = test::BlockOfBone(0.2, Vec3(26, 6, 3));
  const ScenarioResult result = FindScenario("break_through").run(subject, 1);
  const double fraction = Figure(result, "force against the feed, ratio of after to before").value;
  EXPECT_GE(fraction, 0);
  EXPECT_LT(fraction, 1.5);
  EXPECT_EQ(result.what.find("did not break through"), std::string::npos);
}

/// Number of ticks until the force has ramped in, plus ticks until the fault begins.
constexpr std::size_t kBegun = 502 + 800;

/// Returns the longest run of ticks from kBegun on with a constant force above zero.
std::size_t FindLongestHold(const ScenarioResult& result) {
  std::size_t longest = 0;
  std::size_t now = 0;
  for (std::size_t i = kBegun + 1; i < result.force_N.size(); ++i) {
    now = result.force_N[i] == result.force_N[i - 1] && result.force_N[i] > 0 ? now + 1 : 0;
    longest = std::max(longest, now);
  }
  return longest;
}

struct Periods {
  double shortest_ms = 1e9;
  double longest_ms = 0;
};
Periods FindPeriods(const ScenarioResult& result) {
  Periods periods;
  for (std::size_t i = kBegun + 1; i < result.time_s.size(); ++i) {
    const double ms = 1000 * (result.time_s[i] - result.time_s[i - 1]);
    periods.shortest_ms = std::min(periods.shortest_ms, ms);
    periods.longest_ms = std::max(periods.longest_ms, ms);
  }
  return periods;
}

TEST(ScenarioFaults, TimingFaultsMatchTheirNames) {
  const StabilitySubject subject = MakeRunSubject();
  const auto run = [&](const char* name) { return FindScenario(name).run(subject, 1); };
  const ScenarioResult even = run("cut_5N");
  EXPECT_NEAR(FindPeriods(even).shortest_ms, 1, 1e-9);
  EXPECT_NEAR(FindPeriods(even).longest_ms, 1, 1e-9);
  EXPECT_LE(FindLongestHold(even), 1U);

  const Periods jitter = FindPeriods(run("jitter"));
  EXPECT_GE(jitter.shortest_ms, 0.5 - 1e-9);
  EXPECT_LT(jitter.shortest_ms, 0.55);
  EXPECT_GT(jitter.longest_ms, 1.45);
  EXPECT_LE(jitter.longest_ms, 1.5 + 1e-9);

  // One period in a thousand is above 5 ms, so some of 1500 are above 3.5 ms.
  EXPECT_GT(FindPeriods(run("late_ticks")).longest_ms, 3.5);

  // One tick in five is lost, independently of the others: 300 of 1500. The standard deviation is 15.5, and four of
  // them are allowed.
  const ScenarioResult lost = run("lost_ticks");
  int held = 0;
  for (std::size_t i = kBegun + 1; i < lost.force_N.size(); ++i) held += lost.force_N[i] == lost.force_N[i - 1] ? 1 : 0;
  EXPECT_NEAR(held, 0.2 * static_cast<double>(lost.force_N.size() - kBegun), 62);

  EXPECT_NEAR(static_cast<double>(FindLongestHold(run("burst_5ms"))), 5, 1);
  EXPECT_NEAR(static_cast<double>(FindLongestHold(run("burst_50ms"))), 49, 1);
  // The watchdog sets the force to zero after 50 ms.
  const ScenarioResult tripped = run("burst_200ms");
  EXPECT_NEAR(static_cast<double>(FindLongestHold(tripped)), 50, 1);
  const auto zeros = std::count(tripped.force_N.begin() + kBegun, tripped.force_N.end(), 0.0);
  EXPECT_NEAR(static_cast<double>(zeros), 3 * 150, 20);
}

// The same push on the same bone gives the same force until the fault begins, and then a different one. While the
// sample is frozen, the tool continues to cut up to the handle's last position, so the spring slackens; then it
// stretches again.
TEST(ScenarioFaults, FrozenSampleSlackensTheSpring) {
  const StabilitySubject subject = MakeRunSubject();
  const ScenarioResult even = FindScenario("cut_5N").run(subject, 1);
  const ScenarioResult frozen = FindScenario("frozen").run(subject, 1);
  ASSERT_GT(frozen.force_N.size(), kBegun + 300);
  for (std::size_t i = 0; i < kBegun; ++i) ASSERT_EQ(frozen.force_N[i], even.force_N[i]) << i;
  fmt::print("force when it freezes {:.3f} N, after 100 ms {:.3f} N, after 400 ms {:.3f} N; not frozen {:.3f}\n",
             frozen.force_N[kBegun], frozen.force_N[kBegun + 99], frozen.force_N[kBegun + 400],
             even.force_N[kBegun + 99]);
  EXPECT_LT(frozen.force_N[kBegun + 99], frozen.force_N[kBegun] - 0.05);
  EXPECT_GT(even.force_N[kBegun + 99], frozen.force_N[kBegun + 99] + 0.05);
}

// The encoder is as coarse as the coarsest known one, and this is reported.
TEST(ScenarioFaults, CoarseEncoderIsSimulatedAndReported) {
  StabilitySubject subject = MakeRunSubject();
  EXPECT_NE(FindScenario("coarse_encoder").run(subject, 1).what.find("Tested: 64 um; the device has 10 um."),
            std::string::npos);
  EXPECT_NE(FindScenario("coarse_encoder").run(subject, 1).force_N, FindScenario("cut_5N").run(subject, 1).force_N);
}

}  // namespace
}  // namespace kerf
