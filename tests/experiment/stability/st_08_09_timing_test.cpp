// Tests of ticks that come early, late or not at all.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "experiment/stability/held_block.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "experiment/stability/watched_loop.h"

namespace kerf {
namespace {

using test::DrawOrbit;
using test::Effort;
using test::HandOrbit;
using test::HeldBlock;
using test::Verdict;
using test::WatchedLoop;

struct Fault {
  const char* name;
  TimingFaults timing;
};

TimingFaults Make(double jitter, double tail_s, double lost, double burst_s = 0) {
  TimingFaults timing;
  timing.jitter = jitter;
  timing.tail_p999_s = tail_s;
  timing.lost_share = lost;
  timing.burst_s = burst_s;
  timing.burst_every_s = burst_s > 0 ? 0.61 : 0;
  return timing;
}

struct TimingHeld {
  double noise_mN = 0;
  double mean_N = 0;
  double taken_N = 0;  // of the push, by the hand itself; mean
  bool limit_cycle = false;
};

/// Holds a stopped or a running saw with 5 N, without the device's friction.
TimingHeld Hold(const TimingFaults& timing, const char* hand, double rpm) {
  ClosedLoopSetup setup = HeldBlock("omega_6", hand);
  setup.profile.friction_N = 0;
  const Pose start = test::OverBlock();
  WatchedLoop saw(test::BlockOfBone(0.2), setup, start);
  saw.loop.SetTiming(timing);
  const double scale = ForceMap(setup.profile, setup.force_map).force_scale();
  Intention push;
  push.X_WH = start;
  push.yield_s = 0.5;
  std::vector<Vec3> f;
  std::vector<double> f_z;
  TimingHeld held;
  const double until_s = rpm == 0 ? 5.5 : 3.5;
  test::YieldingHand yielding(setup, push.yield_s, start);
  for (ClosedLoopTick tick; tick.time_s < until_s;) {
    push.push_W_N = Vec3(0, 0, -5 * scale * std::min(1.0, tick.time_s / 0.3));
    saw.loop.device().SetIntention(push);
    tick = saw.Step(rpm);
    const double taken_N = yielding.Add(tick, setup.hand) / scale;
    if (tick.time_s < 2) continue;
    held.taken_N += taken_N;
    f.push_back(saw.loop.device().force_N() / scale);
    f_z.push_back(f.back().z);
  }
  for (const double z : f_z) held.mean_N += z / static_cast<double>(f_z.size());
  held.taken_N /= static_cast<double>(f_z.size());
  held.noise_mN = 1000 * CalcNoise(f, setup.period_s);
  held.limit_cycle = FindOscillation(f_z, setup.period_s, 0.02).is_limit_cycle;
  return held;
}

struct TimingRounds {
  double overdrawn = 0;  // as in WatchedLoop
  double lowest_mJ = 0;
  double lowest_handle_mJ = 0;
  double of_held = 0;  // energy returned, as a fraction of the energy of held forces: sum 1/2 K dx^2
  double exchanged_mJ = 0;
  double peak_fraction = 0;  // largest force over the device's peak
  double unexplained = 0;    // as `overdrawn`, minus the energy that gaps can return (see Gaps)
};

/// Energy returned without ticks or during the ramp, and the energy that this may return later. A force that stays
/// constant while the hand moves is not that of a spring, and during the ramp the hand works against less than the full
/// force.
struct Gaps {
  double mJ = 0;
  double motor_mJ = 0;
  bool ramps = false;
  void Add(const ClosedLoopTick& tick, double K_device) {
    const bool ramps_now = tick.out.force.ramp < 1;
    if (tick.dt_s == 0 || ramps_now || ramps) mJ += std::abs(tick.energy.motor_mJ - motor_mJ);
    if (ramps && !ramps_now) {
      const Vec3 x = tick.out.X_WH.p_AB - tick.out.coupled.X_WT.p_AB;
      mJ += 0.5 * K_device * glm::dot(x, x);
    }
    motor_mJ = tick.energy.motor_mJ;
    ramps = ramps_now;
  }
};

TimingRounds RunRounds(const TimingFaults& timing, int rounds, double rpm, bool stiff, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  TimingRounds all;
  for (int i = 0; i < rounds; ++i) {
    CouplingParams asked;
    if (stiff) asked.stiffness_N_per_mm = 1000;
    const char* profiles[] = {"omega_6", "omni", "premium_1_5_hf"};
    const char* hands[] = {"H2", "H3", "H4"};
    const ClosedLoopSetup setup = HeldBlock(profiles[i % 3], hands[(i / 3) % 3], asked);
    const HandOrbit orbit = DrawOrbit(random, 4, 10, rpm != 0);
    WatchedLoop saw(test::BlockOfBone(0.4, Vec3(26, 6, 12)), setup, test::AboveOrbit(orbit));
    TimingFaults own = timing;
    own.seed = seed + 100 * static_cast<std::uint64_t>(i);
    saw.loop.SetTiming(own);
    PortEnergy energy;
    const double K = setup.coupled.coupling.stiffness_N_per_mm * ForceMap(setup.profile, {}).force_scale();
    Gaps gaps;
    test::FollowOrbit(saw, orbit, rpm, [&](const ClosedLoopTick& tick) {
      energy = tick.energy;
      gaps.Add(tick, K);
      const double unexplained_mJ = -(energy.motor_mJ + energy.spindle_mJ) - gaps.mJ - energy.held_mJ;
      all.unexplained = std::max(all.unexplained, unexplained_mJ / std::max(1e-3, 1e-3 * energy.exchanged_mJ));
    });
    all.overdrawn = std::max(all.overdrawn, saw.overdrawn);
    all.lowest_mJ = std::min(all.lowest_mJ, energy.lowest_mJ);
    all.lowest_handle_mJ = std::min(all.lowest_handle_mJ, energy.lowest_handle_mJ);
    if (energy.held_mJ > 0) all.of_held = std::max(all.of_held, -energy.lowest_mJ / energy.held_mJ);
    all.exchanged_mJ += energy.exchanged_mJ;
    all.peak_fraction = std::max(all.peak_fraction, saw.largest_N / setup.profile.peak_force_N);
  }
  return all;
}

std::string Line(const std::string& name, const TimingRounds& all) {
  return fmt::format("{:40} overdrawn {:8.3f} lowest {:9.5f} mJ handle {:9.5f} of held {:6.3f} exchanged {:7.1f}\n",
                     name, all.overdrawn, all.lowest_mJ, all.lowest_handle_mJ, all.of_held, all.exchanged_mJ);
}

TEST(ClosedLoopST8, JitterCausesNoNoiseAndReturnsNoEnergy) {
  Verdict verdict("holds");
  const Fault faults[] = {{"0.5 to 1.5 ms", Make(0.5, 0, 0)},
                          {"tail, 99.9 % below 5 ms", Make(0, 0.005, 0)},
                          {"both", Make(0.5, 0.005, 0)}};
  double noise = 0;
  int cycles = 0;
  std::string table;
  for (const Fault& fault : faults) {
    for (const char* hand : {"H2", "H3", "H4"}) {
      for (const double rpm : {0.0, 7500.0}) {
        const TimingHeld held = Hold(fault.timing, hand, rpm);
        EXPECT_NEAR(held.mean_N + held.taken_N, 5, 0.05) << fault.name << " " << hand;
        noise = std::max(noise, held.noise_mN / std::max(20.0, 10 * held.mean_N));
        cycles += held.limit_cycle ? 1 : 0;
        table += fmt::format("{} {} {} rpm: noise {:.2f} mN of {:.2f} N, {:.2f} N taken by the hand\n", fault.name,
                             hand, rpm, held.noise_mN, held.mean_N, held.taken_N);
      }
    }
  }
  verdict.AtMost("noise above 20 Hz relative to its bound (20 mN or 1 %), worst", noise, 1);
  verdict.Equal("limit cycles", cycles, 0);
  double overdrawn = 0;
  double handle_mJ = 0;
  double of_held = 0;
  for (const Fault& fault : faults) {
    for (const bool stiff : {false, true}) {
      const TimingRounds all = RunRounds(fault.timing, static_cast<int>(std::ceil(9 * Effort())), 0.0, stiff, 7);
      overdrawn = std::max(overdrawn, all.overdrawn);
      handle_mJ = std::min(handle_mJ, all.lowest_handle_mJ);
      of_held = std::max(of_held, all.of_held);
      table += Line(fmt::format("{}{}", fault.name, stiff ? ", stiff" : ""), all);
    }
  }
  std::puts(table.c_str());
  verdict.Note("maximum energy returned at the motors", overdrawn, "times 1e-6 J or 0.1 % of the exchanged energy");
  verdict.AtMost("maximum energy returned relative to what holding can return", of_held, 0.05);
  verdict.AtLeast("minimum energy at the handle", 1000 * handle_mJ, -1e-3, "uJ");
}

// After a lost tick the device keeps its last force, whatever the hand does; after 50 ms the watchdog sets it to zero.
// Then the force ramps in again.
TEST(ClosedLoopST9, LostTicksLeaveTheLoopBounded) {
  Verdict verdict(
      "holds up to 10 ms. A force held for 50 ms while the hand moves on is not computed by the simulation; the "
      "energy that it returns is bounded and reported");
  const Fault faults[] = {{"1 % lost", Make(0, 0, 0.01)},           {"5 % lost", Make(0, 0, 0.05)},
                          {"20 % lost", Make(0, 0, 0.2)},           {"bursts of 5 ms", Make(0, 0, 0, 0.005)},
                          {"bursts of 10 ms", Make(0, 0, 0, 0.01)}, {"bursts of 50 ms", Make(0, 0, 0, 0.05)},
                          {"bursts of 200 ms", Make(0, 0, 0, 0.2)}};
  std::string table;
  double peak = 0;
  double handle_mJ = 0;
  double burst_handle_mJ = 0;
  double of_held = 0;
  double burst_mJ = 0;
  double unexplained = 0;
  for (const Fault& fault : faults) {
    for (const double rpm : {0.0, 7500.0}) {
      const bool burst = fault.timing.burst_s > 0.01;
      const TimingRounds all = RunRounds(fault.timing, static_cast<int>(std::ceil(6 * Effort())), rpm, true, 9);
      peak = std::max(peak, all.peak_fraction);
      unexplained = std::max(unexplained, all.unexplained);
      if (burst) {
        burst_mJ = std::min(burst_mJ, all.lowest_mJ);
        burst_handle_mJ = std::min(burst_handle_mJ, all.lowest_handle_mJ);
      } else {
        of_held = std::max(of_held, all.of_held);
        handle_mJ = std::min(handle_mJ, all.lowest_handle_mJ);
      }
      table += Line(fmt::format("{}, {} rpm", fault.name, rpm), all);
    }
  }
  std::puts(table.c_str());
  verdict.AtMost("largest force relative to the device's peak", peak, 1);
  verdict.AtMost("up to 10 ms: maximum energy returned relative to what holding can return", of_held, 0.05);
  verdict.AtLeast("up to 10 ms: minimum energy at the handle", 1000 * handle_mJ, -1e-3, "uJ");
  verdict.Note("bursts of 50 and 200 ms: minimum energy at the motors", burst_mJ, "mJ");
  verdict.Note("bursts of 50 and 200 ms: minimum energy at the handle", burst_handle_mJ, "mJ");
  verdict.AtMost("energy returned in excess of what the gaps and their ramps return", unexplained, 1,
                 "times the tolerance");
}

// A gap longer than the watchdog's 50 ms sets the force to zero at once, and the ramp follows. A shorter gap leaves the
// force unchanged.
TEST(ClosedLoopST9, ForceReturnsOverTheRampAfterTheWatchdogTrips) {
  Verdict verdict("holds");
  for (const double gap_s : {0.01, 0.2}) {
    const ClosedLoopSetup setup = HeldBlock("omega_6", "H4");
    const Pose start = test::OverBlock();
    WatchedLoop saw(test::BlockOfBone(0.4), setup, start);
    Intention push;
    push.X_WH = start;
    push.push_W_N = Vec3(0, 0, -3);
    push.yield_s = 0.5;
    saw.loop.device().SetIntention(push);
    for (int i = 0; i < 1500; ++i) saw.Step(0);
    const double before_N = glm::length(saw.loop.device().force_N());
    EXPECT_GT(before_N, 1.5);
    TimingFaults timing;
    timing.burst_every_s = 1.6;
    timing.burst_s = gap_s;
    saw.loop.SetTiming(timing);
    for (ClosedLoopTick tick = saw.Step(0); tick.dt_s > 0;) tick = saw.Step(0);
    double min_N = before_N;
    int back_ms = 0;
    for (int i = 0; i < 1000; ++i) {
      const ClosedLoopTick tick = saw.Step(0);
      const double f_N = glm::length(saw.loop.device().force_N());
      min_N = std::min(min_N, f_N);
      if (f_N < 0.9 * before_N && tick.dt_s > 0) ++back_ms;
    }
    if (gap_s < 0.05) {
      verdict.AtLeast("minimum force after 10 ms without ticks relative to that before", min_N / before_N, 0.9);
    } else {
      verdict.Equal("minimum force after 200 ms without ticks", min_N, 0, "N");
      verdict.AtLeast("time until the force has returned", back_ms, 200, "ms");
      verdict.AtMost("time until the force has returned", back_ms, 600, "ms");
    }
  }
}

// The hand moves 8 mm into the block during a gap without ticks. The stretched spring would give 40 N. The force rises
// at the slew rate, from zero to the peak in 5 ms, and in each tick by one period's worth, whatever the length of the
// gap.
TEST(ClosedLoopST9, ForceAfterAGapRisesAtTheSlewRate) {
  Verdict verdict("holds");
  CouplingParams asked;
  asked.stiffness_N_per_mm = 1000;
  const ClosedLoopSetup setup = HeldBlock("omega_6", "H4", asked);
  const Pose start = test::OverBlock(0.5);
  WatchedLoop saw(test::BlockOfBone(0.4), setup, start);
  for (int i = 0; i < 1000; ++i) saw.Step(0);
  TimingFaults timing;
  timing.burst_every_s = 1.05;
  timing.burst_s = 0.045;
  saw.loop.SetTiming(timing);
  for (ClosedLoopTick tick = saw.Step(0); tick.dt_s > 0;) tick = saw.Step(0);
  saw.loop.device().SetIntention({.X_WH = test::OverBlock(-20)});
  for (int i = 0; i < 70; ++i) saw.Step(0);
  const double slew_N = setup.profile.peak_force_N / 0.005 * setup.period_s;
  EXPECT_GT(saw.largest_N, 3 * slew_N);
  verdict.AtLeast("largest rise of the force in a tick relative to the slew limit", saw.largest_rise_N / slew_N, 0.99);
  verdict.AtMost("largest rise of the force in a tick relative to the slew limit", saw.largest_rise_N / slew_N,
                 1 + 1e-9);
}

}  // namespace
}  // namespace kerf
