// Tests of the safety gate: each fault closes it, and no input makes the output too large, too sudden or the motors too
// hot.
#include "device/devices/safety_gate.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "base/core/heap_guard.h"
#include "kerf/error.h"
#include "support/random_cases.h"

namespace kerf {
namespace {

constexpr double kDt_s = 0.001;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kRounding = 1e-12;  // a hundred roundings of numbers up to 100
constexpr double kInfinity = std::numeric_limits<double>::infinity();

DeviceProfile MakeProfile(double peak_N = 8, double continuous_N = 3) {
  DeviceProfile profile;
  profile.peak_force_N = peak_N;
  profile.continuous_force_N = continuous_N;
  profile.peak_torque_Nmm = 100;
  profile.continuous_torque_Nmm = 40;
  return profile;
}

/// A gate with a clock, a simulation that requests the same force each tick, and a device without faults.
struct Bench {
  explicit Bench(const DeviceProfile& profile = MakeProfile(), const SafetyGateOptions& options = {})
      : gate(profile, options) {
    state.homed = state.fresh = state.engaged = true;
    command.f_N = Vec3(2, 0, 0);
  }

  GateOutput Tick() {
    Advance();
    ++command.number;
    command.made_s = state.now_s;
    return out = gate.Step(command, state);
  }
  /// Runs a tick without a new command from the simulation.
  GateOutput Silence() {
    Advance();
    return out = gate.Step(command, state);
  }
  void Advance() {
    state.dt_s = kDt_s;
    state.now_s += kDt_s;
  }
  void Open() {
    for (int i = 0; i < 700; ++i) Tick();
    ASSERT_TRUE(out.open);
    ASSERT_EQ(out.reason, GateReason::kNone);
  }

  SafetyGate gate;
  GateCommand command;
  GateState state;
  GateOutput out;
};

TEST(SafetyGate, EachReasonHasItsSentence) {
  std::set<std::string> sentences;
  for (std::size_t i = 0; i < kGateReasons; ++i) {
    sentences.insert(std::string(Describe(static_cast<GateReason>(i))));
  }
  EXPECT_EQ(sentences.size(), kGateReasons);
  EXPECT_EQ(sentences.count(""), 0U);
}

TEST(SafetyGate, RampsInAsDocumented) {
  // After 100 ms of valid commands, the force rises as 3x^2 - 2x^3 over half a second.
  Bench bench;
  for (int i = 1; i <= 1000; ++i) {
    const GateOutput out = bench.Tick();
    const double x = std::clamp((i - 99) / 500.0, 0.0, 1.0);
    ASSERT_NEAR(out.f_N.x, 2 * x * x * (3 - 2 * x), 1e-9) << i;
    ASSERT_EQ(out.open, i >= 100);
  }
  EXPECT_EQ(bench.gate.count(GateReason::kRampIn), 1U);
  EXPECT_EQ(bench.gate.closed_by(), GateReason::kNone);
}

TEST(SafetyGate, PassesValidCommandsUnchanged) {
  Bench bench;
  bench.Open();
  for (int i = 0; i < 5000; ++i) {
    bench.command.f_N = 2.5 * Vec3(std::cos(0.1 * i), std::sin(0.1 * i), 0);
    bench.command.tau_Nmm = 20.0 * Vec3(0, std::sin(0.1 * i), 1);
    if (i < 3) {
      bench.Tick();
      continue;
    }
    const GateOutput out = bench.Tick();
    ASSERT_LT(glm::length(out.f_N - bench.command.f_N), 1e-12);
    ASSERT_LT(glm::length(out.tau_Nmm - bench.command.tau_Nmm), 1e-12);
  }
}

TEST(SafetyGate, EveryFaultCausesASmoothRampToZero) {
  struct Case {
    GateReason reason;
    std::function<void(Bench&)> step;  // one tick with the fault
    bool passes = true;                // the fault lasts a single tick
  };
  const auto with = [](const std::function<void(Bench&)>& change) {
    return [change](Bench& bench) {
      bench.Advance();
      ++bench.command.number;
      bench.command.made_s = bench.state.now_s;
      change(bench);
      bench.out = bench.gate.Step(bench.command, bench.state);
      bench.state.homed = bench.state.engaged = true;
      bench.command.f_N = Vec3(2, 0, 0);
      bench.command.tau_Nmm = Vec3(0, 0, 30);
    };
  };
  const std::vector<Case> cases = {
      {GateReason::kNotHomed, with([](Bench& b) { b.state.homed = false; })},
      {GateReason::kNotEngaged, with([](Bench& b) { b.state.engaged = false; })},
      {GateReason::kNotFinite, with([](Bench& b) { b.command.f_N.y = kNan; })},
      {GateReason::kNotFinite, with([](Bench& b) { b.command.tau_Nmm.z = -kInfinity; })},
      {GateReason::kNotFinite, with([](Bench& b) { b.command.made_s = kNan; })},
      {GateReason::kOverLimit, with([](Bench& b) { b.command.f_N = Vec3(0, 0, 8.41); })},
      {GateReason::kOverLimit, with([](Bench& b) { b.command.f_N = Vec3(1e300, 1e300, 0); })},
      {GateReason::kOverLimit, with([](Bench& b) { b.command.tau_Nmm = Vec3(0, 106, 0); })},
      {GateReason::kTooSteep, with([](Bench& b) { b.command.f_N = Vec3(3.7, 0, 0); })},
      {GateReason::kTooSteep, with([](Bench& b) { b.command.tau_Nmm = Vec3(0, 0, 51); })},
      {GateReason::kOutOfSequence, with([](Bench& b) { b.command.number -= 2; })},
      {GateReason::kOutOfSequence, with([](Bench& b) { b.command.made_s -= 0.0015; })},
      {GateReason::kOutOfSequence, with([](Bench& b) { b.command.made_s += 0.051; })},
      {GateReason::kClock, with([](Bench& b) { b.state.dt_s = 0.2; })},
      {GateReason::kClock, with([](Bench& b) { b.state.dt_s = kNan; })},
      {GateReason::kClock, with([](Bench& b) { b.state.dt_s = 0; })},
      {GateReason::kClock, with([](Bench& b) { b.state.dt_s = -1; })},
  };
  for (std::size_t n = 0; n < cases.size(); ++n) {
    Bench bench;
    bench.command.tau_Nmm = Vec3(0, 0, 30);
    bench.Open();
    const std::uint64_t before = bench.gate.count(cases[n].reason);
    cases[n].step(bench);
    EXPECT_EQ(bench.out.reason, cases[n].reason) << n;
    EXPECT_EQ(bench.gate.closed_by(), cases[n].reason) << n;
    EXPECT_EQ(bench.gate.count(cases[n].reason), before + 1) << n;
    EXPECT_FALSE(bench.out.open);
    // The output falls from 2 N and 30 N mm to zero over 20 ms; in the meantime the command is valid again, which does
    // not reverse the ramp.
    for (int i = 1; i <= 110; ++i) {
      const double x = std::min(i / 20.0, 1.0);
      const double left = 1 - x * x * (3 - 2 * x);
      ASSERT_NEAR(bench.out.f_N.x, 2 * left, 1e-9) << n << " " << i;
      ASSERT_NEAR(bench.out.tau_Nmm.z, 30 * left, 1e-9) << n << " " << i;
      ASSERT_EQ(bench.out.f_N.y, 0);
      ASSERT_TRUE(i < 20 || bench.out.f_N == Vec3(0)) << n;
      if (i < 90) bench.Tick();
    }
    for (int i = 0; i < 700; ++i) bench.Tick();
    EXPECT_TRUE(bench.out.open) << n;
    EXPECT_EQ(bench.out.f_N, Vec3(2, 0, 0)) << n;
  }
}

TEST(SafetyGate, LongerStepAdvancesTheRampFurther) {
  Bench bench;
  bench.Open();
  bench.state.homed = false;
  bench.Tick();
  bench.state.now_s += 0.05;
  bench.state.dt_s = 0.05;
  EXPECT_EQ(bench.gate.Step(bench.command, bench.state).f_N, Vec3(0));
}

TEST(SafetyGate, GoodCommandsDoNotCutTheRampShort) {
  SafetyGateOptions options;
  options.good_s = 0.002;
  options.ramp_out_s = 0.05;
  Bench bench(MakeProfile(), options);
  bench.Open();
  bench.state.homed = false;
  bench.Tick();
  bench.state.homed = true;
  for (int i = 2; i < 50; ++i) {
    const double x = i / 50.0;
    ASSERT_NEAR(bench.Tick().f_N.x, 2 * (1 - x * x * (3 - 2 * x)), 1e-9);
    ASSERT_FALSE(bench.out.open);
  }
  bench.Tick();
  EXPECT_TRUE(bench.Tick().open);
}

TEST(SafetyGate, SilenceIsAllowedForFiftyMilliseconds) {
  Bench bench;
  bench.Open();
  // The clock is a sum of milliseconds, so the 50th tick may be early or late because of rounding.
  for (int i = 0; i < 49; ++i) ASSERT_TRUE(bench.Silence().open) << i;
  bench.Silence();
  EXPECT_FALSE(bench.Silence().open);
  EXPECT_EQ(bench.gate.closed_by(), GateReason::kStale);
  for (int i = 0; i < 500; ++i) bench.Silence();
  EXPECT_EQ(bench.gate.count(GateReason::kStale), 1U);
  EXPECT_EQ(bench.out.f_N, Vec3(0));
}

TEST(SafetyGate, ADeviceMayBeSilentForFiftyMilliseconds) {
  Bench bench;
  bench.Open();
  bench.state.fresh = false;
  for (int i = 0; i < 49; ++i) ASSERT_TRUE(bench.Tick().open) << i;
  bench.Tick();
  EXPECT_FALSE(bench.Tick().open);
  EXPECT_EQ(bench.gate.closed_by(), GateReason::kLostSample);
  bench.state.fresh = true;
  for (int i = 0; i < 99; ++i) ASSERT_FALSE(bench.Tick().open) << i;
}

TEST(SafetyGate, LargerChangeIsPermittedAfterMissedTicks) {
  // A slew rate of 200 times the peak of 8 N per second is 1.6 N per tick.
  for (const int missed : {0, 1, 3}) {
    for (const bool more : {false, true}) {
      Bench bench;
      bench.command.f_N = Vec3(-3, 0, 0);
      bench.Open();
      for (int i = 0; i < missed; ++i) bench.Silence();
      bench.command.f_N.x += 1.6 * (missed + 1) * (more ? 1.01 : 0.99);
      EXPECT_EQ(bench.Tick().open, !more) << missed;
    }
  }
}

TEST(SafetyGate, NothingBeforeHomingConsentAndAnAnswer) {
  for (int missing = 0; missing < 3; ++missing) {
    Bench bench;
    bench.state.homed = missing != 0;
    bench.state.engaged = missing != 1;
    bench.state.fresh = missing != 2;
    for (int i = 0; i < 2000; ++i) {
      const GateOutput out = bench.Tick();
      ASSERT_EQ(out.f_N, Vec3(0));
      ASSERT_EQ(out.tau_Nmm, Vec3(0));
      ASSERT_FALSE(out.open);
    }
    bench.state.homed = bench.state.engaged = bench.state.fresh = true;
    for (int i = 0; i < 99; ++i) ASSERT_EQ(bench.Tick().f_N, Vec3(0));
    EXPECT_TRUE(bench.Tick().open);
  }
}

TEST(SafetyGate, AcceptsARestartedSimulation) {
  Bench bench;
  bench.Open();
  bench.command.number = 0;
  EXPECT_FALSE(bench.Tick().open);
  for (int i = 0; i < 700; ++i) bench.Tick();
  EXPECT_TRUE(bench.out.open);
}

TEST(SafetyGate, ADeviceWithoutTorqueGetsNone) {
  DeviceProfile profile = MakeProfile();
  profile.peak_torque_Nmm = 0;
  Bench bench(profile);
  bench.command.tau_Nmm = Vec3(1e6, 0, 0);
  bench.Open();
  EXPECT_EQ(bench.out.tau_Nmm, Vec3(0));
  EXPECT_EQ(bench.out.f_N, Vec3(2, 0, 0));
}

TEST(SafetyGate, PeakForceFallsToTheContinuousForce) {
  // With a mean square over 10 s, the full peak is output for -10 s ln(1 - 0.8 C^2/P^2). Then the output falls to C;
  // the mean square never exceeds C^2.
  const double peak = 8;
  const double continuous = 3;
  Bench bench(MakeProfile(peak, continuous));
  bench.command.f_N = Vec3(0, 0, peak / 1.0);
  const double full_s = -10 * std::log(1 - 0.8 * continuous * continuous / (peak * peak));
  double last_full_s = 0;
  double hottest = 0;
  for (int i = 0; i < 60000; ++i) {
    const GateOutput out = bench.Tick();
    if (out.f_N.z > 0.9999 * peak) last_full_s = i * kDt_s - 0.1;
    hottest = std::max(hottest, bench.gate.heat());
  }
  // The ramp adds part of its half second.
  EXPECT_GT(last_full_s, full_s);
  EXPECT_LT(last_full_s, full_s + 0.5);
  EXPECT_NEAR(bench.out.f_N.z, continuous, 0.02 * continuous);
  EXPECT_EQ(bench.out.reason, GateReason::kHeat);
  EXPECT_TRUE(bench.out.open);
  EXPECT_LE(hottest, 1 + 1e-3);
  EXPECT_EQ(bench.gate.count(GateReason::kHeat), 1U);
  // At rest the motors cool by a factor of e in 10 s.
  const double hot = bench.gate.heat();
  bench.command.f_N = Vec3(0);
  for (int i = 0; i < 10000; ++i) bench.Tick();
  EXPECT_NEAR(bench.gate.heat(), hot * std::exp(-1.0), 0.01);
}

TEST(SafetyGate, RestartSetsZeroOutputButKeepsTheHeat) {
  Bench bench;
  bench.command.f_N = Vec3(6, 0, 0);
  bench.Open();
  const double heat = bench.gate.heat();
  bench.gate.Restart();
  // The clock and the sequence numbers both start again with other values.
  bench.state.now_s = -100;
  bench.command.number = 0;
  EXPECT_EQ(bench.Tick().f_N, Vec3(0));
  EXPECT_NEAR(bench.gate.heat(), heat, 2e-4 * heat);
  for (int i = 0; i < 98; ++i) ASSERT_EQ(bench.Tick().f_N, Vec3(0));
  EXPECT_TRUE(bench.Tick().open);
  EXPECT_EQ(bench.gate.closed_by(), GateReason::kNone);
  EXPECT_EQ(bench.gate.count(GateReason::kOutOfSequence), 0U);
}

TEST(SafetyGate, ForcesBelowTheContinuousForceAreNotLimited) {
  Bench bench(MakeProfile(8, 3));
  bench.command.f_N = Vec3(0, 2.6, 0);  // 0.75 of the permitted heat
  bench.Open();
  for (int i = 0; i < 100000; ++i) ASSERT_EQ(bench.Tick().f_N, Vec3(0, 2.6, 0));
}

TEST(SafetyGate, AnUnknownContinuousForceIsHalfThePeak) {
  EXPECT_EQ(SafetyGate(MakeProfile(8, 0)).continuous_force_N(), 4);
  EXPECT_EQ(SafetyGate(MakeProfile(8, 20)).continuous_force_N(), 8);
}

TEST(SafetyGate, RefusesImpossibleOptions) {
  SafetyGateOptions options;
  options.ramp_out_s = 0;
  EXPECT_THROW(SafetyGate(MakeProfile(), options), Error);
  options = {};
  options.over_limit = 0.5;
  EXPECT_THROW(SafetyGate(MakeProfile(), options), Error);
  options = {};
  options.max_slew_per_s = kNan;
  EXPECT_THROW(SafetyGate(MakeProfile(), options), Error);
  EXPECT_THROW(SafetyGate(MakeProfile(-1)), Error);
  EXPECT_THROW(SafetyGate(MakeProfile(kNan)), Error);
}

/// Checks every output against the gate's guarantees.
class Judge {
 public:
  Judge(const SafetyGate& gate, const DeviceProfile& profile) : gate_(gate), profile_(profile) {}

  /// Returns "" or a description of the violation.
  std::string Look(const GateOutput& out, const GateState& state) {
    const double step_s = state.dt_s > 0 && state.dt_s <= 0.1 ? state.dt_s : kDt_s;
    for (int i = 0; i < 3; ++i) {
      if (!std::isfinite(out.f_N[i]) || !std::isfinite(out.tau_Nmm[i])) return "is not finite";
    }
    if (glm::length(out.f_N) > profile_.peak_force_N) return "is beyond the peak force";
    if (std::hypot(out.f_N.x, out.f_N.y, out.f_N.z) > profile_.peak_force_N) return "is beyond the peak force";
    if (glm::length(out.tau_Nmm) > profile_.peak_torque_Nmm) return "is beyond the peak torque";
    if (glm::length(out.f_N - f_N_) > gate_.max_change_N_per_s() * step_s + kRounding) return "is too sudden";
    if (glm::length(out.tau_Nmm - tau_Nmm_) > gate_.max_change_Nmm_per_s() * step_s + kRounding) {
      return "turns too suddenly";
    }
    if (gate_.heat() > 1.02) return "is too hot";
    const bool allowed = state.homed && state.engaged;
    forbidden_s_ = allowed ? 0 : forbidden_s_ + step_s;
    if (forbidden_s_ > 0.0201 && (out.f_N != Vec3(0) || out.tau_Nmm != Vec3(0))) return "outlasts its consent";
    if (!allowed && out.open) return "is open without consent";
    f_N_ = out.f_N;
    tau_Nmm_ = out.tau_Nmm;
    return "";
  }

 private:
  const SafetyGate& gate_;
  DeviceProfile profile_;
  Vec3 f_N_{0};
  Vec3 tau_Nmm_{0};
  double forbidden_s_ = 0;
};

TEST(SafetyGate, KeepsItsGuaranteesOverRandomSteps) {
  const DeviceProfile profile = MakeProfile();
  SafetyGate gate(profile);
  Judge judge(gate, profile);
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> draw(-1, 1);
  const double odd[] = {kNan, kInfinity, -kInfinity, 0, -0.0, 1e300, -1e300, 1e-310, 8.4, 9};
  GateCommand command;
  GateState state;
  int open = 0;
  double angle = 0;
  std::uint64_t fault_interval = 0;  // one in `fault_interval` steps is faulty, so that the gate can open in between
  const int cases = test::CountRandomCases();
  for (int i = 0; i < cases; ++i) {
    if (i % 5000 == 0) fault_interval = i / 5000 % 4 == 0 ? 5 : (i / 5000 % 4 == 1 ? 100 : 3000);
    const auto is_odd = [&] { return random() % fault_interval == 0; };
    state.dt_s = kDt_s * (1 + 0.3 * draw(random));
    if (is_odd()) state.dt_s = 0.3 * draw(random);
    state.now_s += std::max(state.dt_s, 0.0);
    state.homed = !is_odd();
    state.engaged = !is_odd();
    state.fresh = random() % 10 != 0;
    if (random() % 10 != 0) {
      ++command.number;
      command.made_s = state.now_s;
      angle += 0.05 * draw(random);
      command.f_N = 8.0 * std::abs(std::sin(1e-3 * i)) * Vec3(std::cos(angle), std::sin(angle), 0);
      command.tau_Nmm = 100 * std::sin(2e-3 * i) * Vec3(0, 0, 1);
      if (is_odd()) command.f_N[static_cast<int>(random() % 3)] = odd[random() % std::size(odd)];
      if (is_odd()) command.tau_Nmm[static_cast<int>(random() % 3)] = odd[random() % std::size(odd)];
      if (is_odd()) command.made_s = random() % 2 == 0 ? kNan : state.now_s + draw(random);
      if (is_odd()) command.number -= random() % 10;
    }
    GateState reported = state;
    if (is_odd()) reported.now_s = odd[random() % std::size(odd)];
    if (is_odd()) reported.dt_s = odd[random() % std::size(odd)];
    GateOutput out;
    {
      const HeapGuard guard;
      out = gate.Step(command, reported);
    }
    open += out.open ? 1 : 0;
    const std::string wrong = judge.Look(out, reported);
    ASSERT_EQ(wrong, "") << i;
  }
  EXPECT_GT(open, cases / 10);
  for (std::size_t i = 1; i < kGateReasons; ++i) {
    EXPECT_GT(gate.counts()[i], 0U) << Describe(static_cast<GateReason>(i));
  }
}

RC_GTEST_PROP(SafetyGate, KeepsItsGuaranteesForAnySequence, ()) {
  const int peak_N = *rc::gen::inRange(0, 40);
  DeviceProfile profile = MakeProfile(peak_N, *rc::gen::inRange(peak_N / 8 + 1, 41));
  profile.peak_torque_Nmm = *rc::gen::inRange(0, 3) * 50.0;
  SafetyGateOptions options;
  options.ramp_out_s = 0.001 * *rc::gen::inRange(1, 21);
  options.ramp_in_s = 0.001 * *rc::gen::inRange(1, 30);
  options.good_s = 0.001 * *rc::gen::inRange(1, 10);
  options.max_slew_per_s = *rc::gen::inRange(100, 1000);
  SafetyGate gate(profile, options);
  Judge judge(gate, profile);
  GateCommand command;
  GateState state;
  const int steps = *rc::gen::inRange(50, 400);
  const auto seed = *rc::gen::arbitrary<std::uint32_t>();
  const int harm = *rc::gen::inRange(2, 60);
  std::mt19937 random(seed);
  std::normal_distribution<double> draw(0, 0.5);
  for (int i = 0; i < steps; ++i) {
    const auto hit = [&] { return static_cast<int>(random() % 1000) < harm; };
    state.dt_s = hit() ? draw(random) : kDt_s;
    state.now_s += std::max(state.dt_s, 0.0);
    state.homed = !hit();
    state.engaged = !hit();
    state.fresh = !hit();
    if (!hit()) command.number = hit() ? random() % 1000 : command.number + 1;
    command.made_s = hit() ? draw(random) : state.now_s;
    if (hit()) command.f_N = profile.peak_force_N * Vec3(draw(random), draw(random), draw(random));
    if (hit()) command.tau_Nmm = profile.peak_torque_Nmm * Vec3(draw(random), draw(random), draw(random));
    if (hit()) command.f_N = Vec3(kNan, 1, 1);
    if (!std::isfinite(command.f_N.x) && hit()) command.f_N = Vec3(0);
    const std::string wrong = judge.Look(gate.Step(command, state), state);
    if (!wrong.empty()) RC_FAIL(wrong);
  }
}

}  // namespace
}  // namespace kerf
