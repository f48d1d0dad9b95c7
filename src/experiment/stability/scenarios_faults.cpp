// Faults between hand and tick: jumps, lost time, bad samples, and a released handle.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "cut/tool/shape.h"
#include "device/devices/hand.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/scenario_run.h"

namespace kerf {
namespace {

/// From one tick to the next, the measured position of the handle jumps into or beyond the bone, and shortly afterwards
/// back.
ScenarioResult Jump(const StabilitySubject& subject, const Scenario& scenario, double jump_mm, double rpm) {
  ScenarioRun run(subject, scenario);
  run.set_rpm(rpm);
  run.AwaitRamp();
  const Tool& tool = subject.setup.coupled.tool;
  double deepest_mm = -1;
  double travel_mm = 0;
  double removed_mm3 = 0;
  Vec3 p_W = run.tick().out.coupled.X_WT.p_AB;
  run.loop().device().SetFaults({.jump_mm = jump_mm * subject.into_W});
  for (int i = 0; i < 20; ++i) {
    run.Step();
    travel_mm += glm::length(run.tick().out.coupled.X_WT.p_AB - std::exchange(p_W, run.tick().out.coupled.X_WT.p_AB));
    removed_mm3 += run.tick().out.coupled.removed_mm3;
    if (rpm == 0) deepest_mm = std::max(deepest_mm, CalcBuried(subject.bone, tool, run.tick().out.coupled.X_WT));
  }
  run.loop().device().SetFaults({});
  run.Run(0.5);
  // The target is so far out of the bone that friction cannot stop the handle before the tool has left the bone.
  const double k = subject.setup.hand.stiffness_N_per_mm;
  Pose X_away = run.X_WT_start();
  X_away.p_AB -= (2 + (k > 0 ? subject.setup.profile.friction_N / k : 0)) * subject.into_W;
  run.loop().device().SetIntention({.X_WH = X_away});
  // The run lasts until an oscillation of the hand has decayed to a fiftieth.
  const double b = subject.setup.profile.own_damping_Ns_per_mm + subject.setup.hand.damping_Ns_per_mm;
  run.Run(std::clamp(4 * 2e-3 * (subject.setup.profile.mass_kg + subject.setup.hand.mass_kg) / b, 1.0, 6.0));
  const Vec3 p_TC = subject.setup.coupled.coupling.p_TC_mm;
  const double off_mm = glm::length(run.tick().out.coupled.X_WT.Point(p_TC) - run.tick().out.X_WH.Point(p_TC));
  // Whatever the force, the depth must be at most half a voxel, which is the motion in a substep.
  if (rpm == 0)
    run.AtMost("depth of the edge in the bone, maximum", "mm", deepest_mm, 0.5 * subject.bone.voxel_mm() + 0.05);
  if (rpm == 0) run.AtMost("distance of the tool from the handle afterwards", "mm", off_mm, 0.2);
  // The bound is the volume of the sweep, enlarged by half a voxel on all sides.
  const double half_mm = 0.5 * subject.bone.voxel_mm();
  const double R = CalcReach(tool) + half_mm;
  const double thick_mm = CalcThickness(tool) + 2 * half_mm;
  double swept_mm3 = IsBlade(tool) ? thick_mm * (std::numbers::pi * R * R + 2 * R * travel_mm)
                                   : std::numbers::pi * R * R * (4 * R / 3 + travel_mm);
  if (const std::optional<RoundSolid> solid = CalcRoundSolid(tool)) {
    // A cylinder, and at most the area of its diagonal section along the way.
    const double r = solid->top_radius_mm + half_mm;
    const double length_mm = solid->top_z_mm + 2 * half_mm;
    swept_mm3 =
        std::numbers::pi * r * r * length_mm + std::hypot(2 * r * length_mm, std::numbers::pi * r * r) * travel_mm;
  }
  run.AtMost("bone removed during the jump", "mm3", removed_mm3, rpm == 0 ? 0 : swept_mm3);
  return run.Finish();
}

/// From one tick to the next, the hand rotates the tool by 90 degrees.
ScenarioResult QuarterTurn(const StabilitySubject& subject, const Scenario& scenario, double rpm) {
  ScenarioRun run(subject, scenario);
  run.set_rpm(rpm);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(2) * subject.into_W);
  run.Run(0.5);
  Pose X = run.X_WT_start();
  X.R_AB = glm::angleAxis(0.5 * std::numbers::pi, glm::normalize(subject.into_W + X.Vector(Vec3(1, 0, 0)))) * X.R_AB;
  run.loop().device().SetIntention({.X_WH = X});
  run.Run(0.5);
  run.loop().device().SetIntention({.X_WH = run.X_WT_start()});
  run.Run(0.5);
  if (rpm == 0) {
    run.AtMost("depth of the edge in the bone", "mm",
               CalcBuried(subject.bone, subject.setup.coupled.tool, run.tick().out.coupled.X_WT),
               0.5 * subject.bone.voxel_mm() + 0.05);
  }
  return run.Finish();
}

/// Shortens a burst that would exceed the watchdog limit only because it is rounded to whole ticks.
double FitBurst_s(double burst_s, double period_s, double watchdog_ms) {
  const double limit_s = 1e-3 * watchdog_ms;
  // Number of ticks that may be lost; the force is one tick older than that.
  const double lost = std::floor(limit_s / period_s + 1e-6) - 1;
  return burst_s <= limit_s && lost >= 1 ? std::min(burst_s, (lost - 0.5) * period_s) : burst_s;
}

/// The hand pushes with 5 N while the ticks are irregular.
ScenarioResult UnevenTime(const StabilitySubject& subject, const Scenario& scenario, TimingFaults timing,
                          std::uint64_t seed) {
  ScenarioRun run(subject, scenario);
  timing.seed = seed;
  timing.burst_s = FitBurst_s(timing.burst_s, run.T(), subject.setup.watchdog_ms);
  run.AwaitRamp();
  run.Lean(run.FindCutPush_N(5, subject.setup.hand));
  run.Run(0.8);
  const std::size_t start = run.now();
  run.loop().SetTiming(timing);
  const double oldest_s = (std::ceil(timing.burst_s / run.T() - 1e-6) + 1) * run.T();
  const bool trips = timing.burst_s > 0 && 1000 * oldest_s > subject.setup.watchdog_ms * (1 + 1e-9);
  if (trips) {
    run.Run(1.5);  // not RunInBone(), since here a vanishing force does not mean that the tool is through
    const auto forces = run.forces_N(start);
    run.AtLeast("ticks without force", "", static_cast<double>(std::count(forces.begin(), forces.end(), Vec3(0))), 1);
  } else {
    // A hand feels a step of 7 % of the force; half of that is allowed.
    run.AddNoise(start, run.RunInBone(1.5), 0.035);
    run.AddEnergy();
  }
  return run.Finish();
}

/// The hand releases the handle in the middle of a cut and grips it again.
ScenarioResult LetGo(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.FindCutPush_N(5, subject.setup.hand));
  run.Run(1);
  const double held_N = glm::length(run.tick().f_device_N);
  const double start_mm_per_s = glm::length(run.tick().v_WC_mm_per_s);
  if (run.IsOff(0.05) || run.is_through()) {
    run.LeaveUnjudged("The tool was off the bone before the handle was released.");
    return run.Finish();
  }
  const std::size_t released = run.now();
  run.Release();
  run.Run(0.7);
  double max_N = 0;
  for (const Vec3& f : run.forces_N(released)) max_N = std::max(max_N, glm::length(f));
  double fastest = 0;
  const auto p = run.positions_mm(released);
  for (std::size_t i = 1; i < p.size(); ++i) fastest = std::max(fastest, glm::length(p[i] - p[i - 1]) / run.T());
  run.AtMost("rise of the force after the release", "%", 100 * (max_N / std::max(held_N, 1e-3) - 1), 5);
  // Speed of the handle if it takes up all the energy of the spring in addition to its own kinetic energy.
  const double K = run.scale() * subject.setup.coupled.coupling.stiffness_N_per_mm;
  const double bound = std::hypot(held_N / std::sqrt(K * 1e-3 * subject.setup.profile.mass_kg), start_mm_per_s);
  run.AtMost("speed of the released handle", "mm/s", fastest, 1.1 * bound + 10);
  const HandModel& firm = FindHandModel("H4");
  run.Grip(firm);
  run.Lean(run.FindCutPush_N(5, firm));
  run.Run(1.5);
  const std::size_t again = run.now();
  run.AddNoise(again, run.RunInBone(0.5));
  return run.Finish();
}

ScenarioResult NotANumber(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.FindCutPush_N(5, subject.setup.hand));
  run.Run(0.8);
  double max_N = 0;
  double removed_mm3 = 0;
  for (int round = 0; round < 3; ++round) {
    run.loop().device().SetFaults({.not_a_number = true});
    run.Step();
    for (int i = 0; i < 20; ++i) {
      run.Step();
      max_N = std::max(max_N, glm::length(run.tick().f_device_N));
      removed_mm3 += run.tick().out.coupled.removed_mm3;
    }
    run.loop().device().SetFaults({});
    run.Run(0.2);
  }
  run.AtMost("force while the samples are bad", "N", max_N, 0);
  run.AtMost("bone removed meanwhile", "mm3", removed_mm3, 0);
  run.AtMost("remaining faults", "", run.tick().out.faults, 0);
  return run.Finish();
}

/// The device repeats the same sample for a tenth of a second while the hand moves on.
ScenarioResult Frozen(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.FindCutPush_N(5, subject.setup.hand));
  run.Run(0.8);
  run.loop().device().SetFaults({.frozen = true});
  run.Run(0.1);
  run.loop().device().SetFaults({});
  run.Run(0.7);
  const std::size_t after = run.now();
  run.AddNoise(after, run.RunInBone(0.5));
  return run.Finish();
}

/// The device has the coarsest encoder of any known device.
ScenarioResult CoarseEncoder(const StabilitySubject& asked, const Scenario& scenario, std::uint64_t) {
  StabilitySubject subject = asked;
  subject.setup.quantise = true;
  subject.setup.profile.resolution_mm = std::max(0.064, subject.setup.profile.resolution_mm);
  ScenarioRun run(subject, scenario);
  run.Say(fmt::format(" Tested: {:.3g} um; the device has {:.3g} um.", 1000 * subject.setup.profile.resolution_mm,
                      1000 * asked.setup.profile.resolution_mm));
  run.AwaitRamp();
  run.Lean(run.FindCutPush_N(5, subject.setup.hand));
  run.Run(0.8);
  const std::size_t start = run.now();
  run.AddNoise(start, run.RunInBone(1));
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
        figure.name += ", spindle rotating";
        stopped.figures.push_back(figure);
      }
      return stopped;
    };
  };
  Add(all, "jump_1mm", "The handle jumps 1 mm into the bone within a tick, and back 20 ticks later.", jump(1));
  Add(all, "jump_5mm", "The same with 5 mm.", jump(5));
  Add(all, "jump_20mm", "The same with 20 mm.", jump(20));
  Add(all, "jump_100mm", "The same with 100 mm.", jump(100));
  Add(all, "quarter_turn", "The pushing hand turns by 90 degrees within a tick, and back; spindle stopped.",
      [](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
        return QuarterTurn(subject, scenario, 0);
      });
  Add(all, "quarter_turn_turning", "The same with the spindle rotating.",
      [](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
        return QuarterTurn(subject, scenario, subject.rpm);
      });
  const auto uneven = [](const TimingFaults& timing) {
    return [=](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t seed) {
      return UnevenTime(subject, scenario, timing, seed);
    };
  };
  Add(all, "jitter", "Tick periods vary at random from 0.5 to 1.5 times the nominal one; the hand pushes with 5 N.",
      uneven({.jitter = 0.5}));
  Add(all, "late_ticks", "One tick in 1000 takes 5 ms or more.", uneven({.tail_p999_s = 0.005}));
  Add(all, "lost_ticks", "One tick in five is lost.", uneven({.lost_share = 0.2}));
  Add(all, "burst_5ms", "Twice a second, all ticks are lost for 5 ms.",
      uneven({.burst_every_s = 0.5, .burst_s = 0.005}));
  Add(all, "burst_50ms", "The same with 50 ms, the longest gap that the watchdog tolerates.",
      uneven({.burst_every_s = 0.5, .burst_s = 0.049}));
  Add(all, "burst_200ms", "The same with 200 ms, which the watchdog does not tolerate.",
      uneven({.burst_every_s = 0.5, .burst_s = 0.2}));
  Add(all, "let_go", "The hand releases the handle in the middle of a cut and grips it again, firmly.", LetGo);
  Add(all, "not_a_number", "The device returns samples that are not numbers.", NotANumber);
  Add(all, "frozen", "The device returns the same sample for a tenth of a second.", Frozen);
  Add(all, "coarse_encoder", "The encoder step is 64 um, the largest known, or that of the device if larger.",
      CoarseEncoder);
}

}  // namespace kerf
