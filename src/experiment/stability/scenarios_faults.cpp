// What can go wrong between hand and tick: jumps, lost time, bad samples, and a hand that lets go.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "device/devices/hand.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/scenario_run.h"

namespace kerf {
namespace {

constexpr double kPi = 3.14159265358979323846;

/// From one tick to the next the handle is read to be elsewhere, in the bone or beyond, and a little later back again.
ScenarioResult Jump(const StabilitySubject& subject, const Scenario& scenario, double jump_mm, double rpm) {
  ScenarioRun run(subject, scenario);
  run.set_rpm(rpm);
  run.AwaitRamp();
  const Tool& tool = subject.setup.coupled.tool;
  double deepest_mm = -1;
  double way_mm = 0;
  double removed_mm3 = 0;
  Vec3 p_W = run.tick().out.coupled.X_WT.p_AB;
  run.loop().device().SetFaults({.jump_mm = jump_mm * subject.into_W});
  for (int i = 0; i < 20; ++i) {
    run.Step();
    way_mm += glm::length(run.tick().out.coupled.X_WT.p_AB - std::exchange(p_W, run.tick().out.coupled.X_WT.p_AB));
    removed_mm3 += run.tick().out.coupled.removed_mm3;
    if (rpm == 0) deepest_mm = std::max(deepest_mm, CalcBuried(subject.bone, tool, run.tick().out.coupled.X_WT));
  }
  run.loop().device().SetFaults({});
  run.Run(0.5);
  // Out of the bone, further than the device's friction can hold the handle back from where the hand wants it.
  const double k = subject.setup.hand.stiffness_N_per_mm;
  Pose X_away = run.X_WT_start();
  X_away.p_AB -= (2 + (k > 0 ? subject.setup.profile.friction_N / k : 0)) * subject.into_W;
  run.loop().device().SetIntention({.X_WH = X_away});
  // Until a swing of the hand's has come down to a fiftieth.
  const double b = subject.setup.profile.own_damping_Ns_per_mm + subject.setup.hand.damping_Ns_per_mm;
  run.Run(std::clamp(4 * 2e-3 * (subject.setup.profile.mass_kg + subject.setup.hand.mass_kg) / b, 1.0, 6.0));
  const Vec3 p_TC = subject.setup.coupled.coupling.p_TC_mm;
  const double off_mm = glm::length(run.tick().out.coupled.X_WT.Point(p_TC) - run.tick().out.sample.X_WH.Point(p_TC));
  // It comes no deeper than the half voxel of a sub-step, whatever the pull.
  if (rpm == 0) run.AtMost("edge in the bone, deepest", "mm", deepest_mm, 0.5 * subject.bone.voxel_mm() + 0.05);
  if (rpm == 0) run.AtMost("tool from the handle afterwards", "mm", off_mm, 0.2);
  // Not more than it swept, with half a voxel all round.
  const double half_mm = 0.5 * subject.bone.voxel_mm();
  const auto* disc = std::get_if<DiscSaw>(&tool);
  const double R = CalcReach(tool) + half_mm;
  const double thick_mm = disc ? disc->thickness_mm + 2 * half_mm : 0;
  const double swept_mm3 = disc ? thick_mm * (kPi * R * R + 2 * R * way_mm) : kPi * R * R * (4 * R / 3 + way_mm);
  run.AtMost("bone removed in the jump", "mm3", removed_mm3, rpm == 0 ? 0 : swept_mm3);
  return run.Finish();
}

/// From one tick to the next the hand holds the tool turned by 90 degrees.
ScenarioResult QuarterTurn(const StabilitySubject& subject, const Scenario& scenario, double rpm) {
  ScenarioRun run(subject, scenario);
  run.set_rpm(rpm);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(2) * subject.into_W);
  run.Run(0.5);
  Pose X = run.X_WT_start();
  X.R_AB = glm::angleAxis(0.5 * kPi, glm::normalize(subject.into_W + X.Vector(Vec3(1, 0, 0)))) * X.R_AB;
  run.loop().device().SetIntention({.X_WH = X});
  run.Run(0.5);
  run.loop().device().SetIntention({.X_WH = run.X_WT_start()});
  run.Run(0.5);
  if (rpm == 0) {
    run.AtMost("edge in the bone", "mm",
               CalcBuried(subject.bone, subject.setup.coupled.tool, run.tick().out.coupled.X_WT),
               0.5 * subject.bone.voxel_mm() + 0.05);
  }
  return run.Finish();
}

/// Shortened to what the watchdog bears: a burst that it would bear but for the last tick's rounding.
double FitBurst_s(double burst_s, double period_s, double watchdog_ms) {
  const double limit_s = 1e-3 * watchdog_ms;
  // So many lost ticks, and the force is one tick older than they are.
  const double lost = std::floor(limit_s / period_s + 1e-6) - 1;
  return burst_s <= limit_s && lost >= 1 ? std::min(burst_s, (lost - 0.5) * period_s) : burst_s;
}

/// Pushed with 5 N, in a time that is not even.
ScenarioResult UnevenTime(const StabilitySubject& subject, const Scenario& scenario, TimingFaults timing,
                          std::uint64_t seed) {
  ScenarioRun run(subject, scenario);
  timing.seed = seed;
  timing.burst_s = FitBurst_s(timing.burst_s, run.T(), subject.setup.watchdog_ms);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(5) * subject.into_W);
  run.Run(0.8);
  const std::size_t begun = run.now();
  run.loop().SetTiming(timing);
  const double oldest_s = (std::ceil(timing.burst_s / run.T() - 1e-6) + 1) * run.T();
  const bool trips = timing.burst_s > 0 && 1000 * oldest_s > subject.setup.watchdog_ms * (1 + 1e-9);
  if (trips) {
    run.Run(1.5);  // all of it: that the force goes does not say that the tool is through
    const auto forces = run.forces_N(begun);
    run.AtLeast("ticks without force", "", static_cast<double>(std::count(forces.begin(), forces.end(), Vec3(0))), 1);
  } else {
    // A hand feels a step of 7 % of the force; half of that is allowed.
    run.AddNoise(begun, run.RunInBone(1.5), 0.035);
    run.AddEnergy();
  }
  return run.Finish();
}

/// Let go of in the middle of a cut, and gripped again.
ScenarioResult LetGo(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  const Vec3 push_N = run.CalcPush_N(5) * subject.into_W;
  run.Lean(push_N);
  run.Run(1);
  const double held_N = glm::length(run.tick().f_device_N);
  const double begun_mm_per_s = glm::length(run.tick().v_WC_mm_per_s);
  if (run.IsOff(0.05) || run.is_through()) {
    run.LeaveUnjudged("The tool was off the bone before the hand let go.");
    return run.Finish();
  }
  const std::size_t released = run.now();
  run.Release();
  run.Run(0.7);
  double most_N = 0;
  for (const Vec3& f : run.forces_N(released)) most_N = std::max(most_N, glm::length(f));
  double fastest = 0;
  const auto p = run.positions_mm(released);
  for (std::size_t i = 1; i < p.size(); ++i) fastest = std::max(fastest, glm::length(p[i] - p[i - 1]) / run.T());
  run.AtMost("rise of the force after letting go", "%", 100 * (most_N / std::max(held_N, 1e-3) - 1), 5);
  // All that the spring holds, as motion of the handle, and that which it had.
  const double K = run.scale() * subject.setup.coupled.coupling.stiffness_N_per_mm;
  const double bound = std::hypot(held_N / std::sqrt(K * 1e-3 * subject.setup.profile.mass_kg), begun_mm_per_s);
  run.AtMost("speed of the handle let go of", "mm/s", fastest, 1.1 * bound + 10);
  run.Grip(FindHandModel("H4"));
  run.Lean(push_N);
  run.Run(1.5);
  const std::size_t again = run.now();
  run.AddNoise(again, run.RunInBone(0.5));
  return run.Finish();
}

ScenarioResult NotANumber(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(5) * subject.into_W);
  run.Run(0.8);
  double most_N = 0;
  double removed_mm3 = 0;
  for (int round = 0; round < 3; ++round) {
    run.loop().device().SetFaults({.not_a_number = true});
    run.Step();
    for (int i = 0; i < 20; ++i) {
      run.Step();
      most_N = std::max(most_N, glm::length(run.tick().f_device_N));
      removed_mm3 += run.tick().out.coupled.removed_mm3;
    }
    run.loop().device().SetFaults({});
    run.Run(0.2);
  }
  run.AtMost("force while the samples are bad", "N", most_N, 0);
  run.AtMost("bone removed meanwhile", "mm3", removed_mm3, 0);
  run.AtMost("faults left", "", run.tick().out.faults, 0);
  return run.Finish();
}

/// The device gives the same sample for a tenth of a second while the hand moves on.
ScenarioResult Frozen(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(5) * subject.into_W);
  run.Run(0.8);
  run.loop().device().SetFaults({.frozen = true});
  run.Run(0.1);
  run.loop().device().SetFaults({});
  run.Run(0.7);
  const std::size_t after = run.now();
  run.AddNoise(after, run.RunInBone(0.5));
  return run.Finish();
}

/// The device's encoder is as coarse as any known.
ScenarioResult CoarseEncoder(const StabilitySubject& asked, const Scenario& scenario, std::uint64_t) {
  StabilitySubject subject = asked;
  subject.setup.quantise = true;
  subject.setup.profile.resolution_mm = std::max(0.064, subject.setup.profile.resolution_mm);
  ScenarioRun run(subject, scenario);
  run.Say(fmt::format(" Tried: {:.3g} um, the device has {:.3g} um.", 1000 * subject.setup.profile.resolution_mm,
                      1000 * asked.setup.profile.resolution_mm));
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(5) * subject.into_W);
  run.Run(0.8);
  const std::size_t begun = run.now();
  run.AddNoise(begun, run.RunInBone(1));
  return run.Finish();
}

}  // namespace

void AddFaultScenarios(std::vector<Scenario>& all) {
  const auto jump = [](double jump_mm) {
    return [=](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
      ScenarioResult stopped = Jump(subject, scenario, jump_mm, 0);
      if (std::abs(subject.rpm) < 1) return stopped;
      const ScenarioResult turning = Jump(subject, scenario, jump_mm, subject.rpm);
      for (StabilityFigure figure : turning.figures) {
        figure.name += ", turning";
        stopped.figures.push_back(figure);
      }
      return stopped;
    };
  };
  Add(all, "jump_1mm", "The handle jumps by 1 mm into the bone in a tick, and 20 ticks later back.", jump(1));
  Add(all, "jump_5mm", "The same with 5 mm.", jump(5));
  Add(all, "jump_20mm", "The same with 20 mm.", jump(20));
  Add(all, "jump_100mm", "The same with 100 mm.", jump(100));
  Add(all, "quarter_turn", "The hand, pushing, turns by 90 degrees in a tick, and back; spindle stopped.",
      [](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
        return QuarterTurn(subject, scenario, 0);
      });
  Add(all, "quarter_turn_turning", "The same with the spindle turning.",
      [](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
        return QuarterTurn(subject, scenario, subject.rpm);
      });
  const auto uneven = [](const TimingFaults& timing) {
    return [=](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t seed) {
      return UnevenTime(subject, scenario, timing, seed);
    };
  };
  Add(all, "jitter", "Ticks come half a period early to half a period late while the hand pushes with 5 N.",
      uneven({.jitter = 0.5}));
  Add(all, "late_ticks", "One tick in 1000 takes 5 ms or more.", uneven({.tail_p999_s = 0.005}));
  Add(all, "lost_ticks", "One tick in five is lost.", uneven({.lost_share = 0.2}));
  Add(all, "burst_5ms", "Twice a second all ticks of 5 ms are lost.", uneven({.burst_every_s = 0.5, .burst_s = 0.005}));
  Add(all, "burst_50ms", "The same with 50 ms, the most that the watchdog bears.",
      uneven({.burst_every_s = 0.5, .burst_s = 0.049}));
  Add(all, "burst_200ms", "The same with 200 ms, which the watchdog does not bear.",
      uneven({.burst_every_s = 0.5, .burst_s = 0.2}));
  Add(all, "let_go", "The hand lets go in the middle of a cut, and grips again, firmly.", LetGo);
  Add(all, "not_a_number", "The device gives samples that are not numbers.", NotANumber);
  Add(all, "frozen", "The device gives the same sample for a tenth of a second.", Frozen);
  Add(all, "coarse_encoder", "The encoder's steps are 64 um, the longest known, or the device's own.", CoarseEncoder);
}

}  // namespace kerf
