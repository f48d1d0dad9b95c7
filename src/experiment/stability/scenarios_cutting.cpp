// Scenarios with a rotating spindle: cutting, the kerf, breaking through, and different hands.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "cut/tool/looks.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/scenario_run.h"

namespace kerf {
namespace {

constexpr const char* kSpindleStopped = "the spindle is stopped.";
constexpr double kThin_mm = 8;  // maximum thickness of the bone; breaking through a thicker one takes too long

bool Turns(const StabilitySubject& subject) {
  return std::abs(subject.rpm) >= 1;
}

ScenarioResult CutUnderPush(const StabilitySubject& subject, const Scenario& scenario, double simulated_N) {
  if (!Turns(subject)) return ScenarioRun::Skip(scenario, kSpindleStopped);
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(simulated_N) * subject.into_W);
  run.Run(0.6);
  const std::size_t start = run.now();
  const std::size_t end = run.RunInBone(1.5);
  run.AddCutNoise(start, end);
  if (end > start + 1) {
    const TickSteps steps = CalcTickSteps(run.forces_N(start, end));
    // A stiff coupling turns each encoder step into a force. If this force can be felt, the result says that the
    // encoder is its cause.
    const double grain = run.CalcGrain(run.MeanForce_N(start, end));
    if (grain > 1)
      run.Say(fmt::format(" An encoder step changes the force by {:.2g} just-noticeable differences.", grain));
    run.AtMost("perceived force step, 99.9 %", "just noticeable", steps.p999, 1);
    run.AtMost("perceived force step, largest", "just noticeable", steps.max, 2);
  }
  run.AddEnergy();
  return run.Finish();
}

/// The hand leans from side to side in the kerf, once a second.
ScenarioResult Sideways(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  if (!Turns(subject)) return ScenarioRun::Skip(scenario, kSpindleStopped);
  if (subject.setup.hand.stiffness_N_per_mm <= 0) {
    return ScenarioRun::Skip(scenario, "no hand holds a released device.");
  }
  const HeldTool held = HoldTool(subject, HeldState::kInKerf);
  ScenarioRun run(subject, scenario, held);
  run.AwaitRamp();
  const std::size_t start = run.now();
  // The push deflects the coupling by at most 1 mm, because otherwise friction would pull the tool out along the wall.
  const double push_N = run.CalcPush_N(std::min(2.0, subject.setup.coupled.coupling.stiffness_N_per_mm));
  const Tool& tool = subject.setup.coupled.tool;
  // The motion is measured at the edge in the kerf, not at the centre, which tilts with the hand.
  const Vec3 front_T = FindForemost(tool, held.X_WT.InverseVector(subject.into_W));
  const Vec3 front_W = held.X_WT.Point(front_T);
  double wander_mm = 0;
  for (int i = 0; i < static_cast<int>(2 / run.T()); ++i) {
    const double lean = std::sin(2 * std::numbers::pi * i * run.T());
    run.loop().device().SetIntention({.X_WH = held.X_WT, .push_W_N = lean * push_N * held.push_W});
    const ClosedLoopTick& tick = run.Step();
    wander_mm = std::max(wander_mm, std::abs(glm::dot(tick.out.coupled.X_WT.Point(front_T) - front_W, held.push_W)));
  }
  // The tool moves from one wall to the other. This may be felt, but not as roughness, so half a just-noticeable
  // difference is allowed.
  // Friction along a stroke is no roughness: it alternates with the stroke.
  const Vec3 along_W = CalcStroke(tool) > 0 ? held.X_WT.Vector({0, 1, 0}) : Vec3(0);
  std::vector<Vec3> forces_N;
  for (const Vec3& f : run.forces_N(start)) forces_N.push_back(f - glm::dot(f, along_W) * along_W);
  run.AtMost("noise above 20 Hz", "mN", 1000 * CalcNoise(forces_N, run.T()), std::max(20.0, 35 * push_N));
  // Voxels much larger than the disc's thickness cannot represent a kerf.
  if (IsBlade(tool) && subject.bone.voxel_mm() <= 4 * CalcThickness(tool)) {
    run.AtMost("motion of the disc out of its plane", "mm", wander_mm, 0.1 + 0.5 * subject.bone.voxel_mm());
  }
  run.AddEnergy();
  return run.Finish();
}

/// Rotates the stopped tool in the kerf about the feed direction, by 3 degrees in either direction.
ScenarioResult Tilt(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  const HeldTool held = HoldTool(subject, HeldState::kInKerf);
  ScenarioRun run(subject, scenario, held);
  run.set_rpm(0);
  run.AwaitRamp();
  constexpr double kTilt_rad = 3 * std::numbers::pi / 180;
  std::vector<Vec3> torques_Nmm;
  double max_Nmm = 0;
  const std::size_t start = run.now();
  for (int i = 0; i < static_cast<int>(2 / run.T()); ++i) {
    const double t = i * run.T();
    Intention intention{.X_WH = held.X_WT};
    const double angle = kTilt_rad * std::sin(std::numbers::pi * t) * std::abs(std::sin(std::numbers::pi * t));
    intention.X_WH.R_AB = glm::angleAxis(angle, subject.into_W) * held.X_WT.R_AB;
    run.loop().device().SetIntention(intention);
    torques_Nmm.push_back(run.Step().out.force.tau_H_W_Nmm);
    max_Nmm = std::max(max_Nmm, glm::length(torques_Nmm.back()));
  }
  const std::size_t after = run.now();
  run.loop().device().SetIntention({.X_WH = held.X_WT});
  run.Run(0.5);
  double max_N = 0;
  for (const Vec3& f : run.forces_N(start, after)) max_N = std::max(max_N, glm::length(f));
  run.AddNoise(start);
  if (max_Nmm > 0) {
    run.AtMost("noise of the torque above 20 Hz", "N mm", CalcNoise(torques_Nmm, run.T()),
               std::max(1.0, 0.01 * max_Nmm));
  }
  run.AtMost("force after tilting back", "N", run.MeanForce_N(after + (run.now() - after) / 2),
             0.02 + 0.1 * max_N + subject.setup.profile.friction_N);
  return run.Finish();
}

ScenarioResult BreakThrough(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  if (!Turns(subject)) return ScenarioRun::Skip(scenario, kSpindleStopped);
  const double thickness_mm = CalcThickness(subject, kThin_mm);
  if (!(thickness_mm < kThin_mm)) {
    return ScenarioRun::Skip(scenario, fmt::format("the bone is thicker than {} mm along the feed.", kThin_mm));
  }
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.CalcPush_N(5) * subject.into_W);
  double before_N = 0;
  double after_N = 0;
  bool through = false;
  for (int i = 0; i < static_cast<int>(6 / run.T()); ++i) {
    const ClosedLoopTick& tick = run.Step();
    through =
        through || glm::dot(tick.out.coupled.X_WT.p_AB - run.X_WT_start().p_AB, subject.into_W) > thickness_mm + 1.5;
    double& max_N = through ? after_N : before_N;
    max_N = std::max(max_N, -glm::dot(tick.f_device_N, subject.into_W));
  }
  if (!through) {
    run.LeaveUnjudged("The tool did not break through in 6 s.");
    return run.Finish();
  }
  // Before the hand stops the tool, it may hit a surface up to d = 2 mm behind the bone. The force there is at most F
  // (1 + sqrt(1 + 2 K d / F)).
  const double K = run.scale() * subject.setup.coupled.coupling.stiffness_N_per_mm;
  run.AtMost("force against the feed, ratio of after to before", "", after_N / before_N,
             1 + std::sqrt(1 + 2 * K * 2 / std::max(before_N, 1e-3)));
  return run.Finish();
}

/// The spindle is reversed, stopped and started again in the middle of a cut, each within one tick.
ScenarioResult SpindleChanges(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
  if (!Turns(subject)) return ScenarioRun::Skip(scenario, kSpindleStopped);
  ScenarioRun run(subject, scenario);
  run.AwaitRamp();
  run.Lean(run.FindCutPush_N(5, subject.setup.hand));
  run.Run(0.8);
  double largest = 0;
  bool changed = false;
  for (const double rpm : {-subject.rpm, 0.0, subject.rpm, 0.0, -subject.rpm}) {
    const std::size_t before = run.now() - 1;
    run.set_rpm(rpm);
    run.Run(0.2);
    // Only the ticks right after the change count, not later contacts.
    if (run.is_through()) break;
    largest = std::max(largest, CalcTickSteps(run.forces_N(before, before + 20)).max);
    changed = true;
  }
  if (!changed) {
    run.LeaveUnjudged("The tool had cut through the bone before the spindle was changed.");
    return run.Finish();
  }
  run.AtMost("perceived force step, largest", "just noticeable", largest, 2);
  run.AddEnergy();
  return run.Finish();
}

/// Tries random hands within the range of measured hands; the result names the worst one.
ScenarioResult AnyHand(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto draw = [&](double lower, double upper) {
    const double fraction = static_cast<double>(random() >> 11U) * 0x1p-53;
    return lower * std::pow(upper / lower, fraction);
  };
  constexpr int kHands = 6;
  ScenarioResult worst;
  double worst_fraction = -1;
  for (int i = 0; i < kHands; ++i) {
    StabilitySubject held = subject;
    held.setup.hand.name = "random";
    held.setup.hand.mass_kg = draw(0.02, 1);
    held.setup.hand.damping_Ns_per_mm = 1e-3 * draw(0.5, 20);
    held.setup.hand.stiffness_N_per_mm = 1e-3 * draw(1, 1000);
    const double push_N = draw(1, 20);
    ScenarioRun run(held, scenario);
    run.AwaitRamp();
    run.Lean(run.FindCutPush_N(push_N, held.setup.hand));
    run.Run(1);
    const std::size_t early = run.now();
    run.Run(0.5);
    const std::size_t late = run.now();
    const std::size_t end = run.RunInBone(0.5);
    if (static_cast<double>(end - late) * run.T() < 0.25) continue;
    const double noise_mN = 1000 * CalcNoise(run.forces_N(late, end), run.T());
    // A heavy hand with little damping keeps ringing from the onset of the push. This ringing must decay.
    const double before_mN = 1000 * CalcNoise(run.forces_N(early, late), run.T());
    const double bound_mN = std::max({20.0, 10 * run.MeanForce_N(late, end), 0.75 * before_mN});
    run.AtMost("noise above 20 Hz", "mN", noise_mN, bound_mN);
    run.AddEnergy();
    run.Say(fmt::format(" The worst of {} hands: {:.3f} kg, {:.2f} N s/m, {:.0f} N/m, pushing with {:.1f} N.", kHands,
                        held.setup.hand.mass_kg, 1000 * held.setup.hand.damping_Ns_per_mm,
                        1000 * held.setup.hand.stiffness_N_per_mm, push_N));
    ScenarioResult result = run.Finish();
    const double fraction = result.holds() ? noise_mN / bound_mN : 2 + noise_mN / bound_mN;
    if (fraction > worst_fraction) {
      worst_fraction = fraction;
      worst = std::move(result);
    }
  }
  if (worst_fraction < 0)
    return ScenarioRun::NotJudged(scenario, "The tool had cut through the bone before any hand could be judged.");
  return worst;
}

}  // namespace

void AddCuttingScenarios(std::vector<Scenario>& all) {
  const auto cut = [](double simulated_N) {
    return [=](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
      return CutUnderPush(subject, scenario, simulated_N);
    };
  };
  Add(all, "cut_1N", "The hand pushes the rotating tool into the bone with 1 N.", cut(1));
  Add(all, "cut_5N", "The same with 5 N.", cut(5));
  Add(all, "cut_20N", "The same with 20 N, or the device's continuous force if lower.", cut(20));
  Add(all, "sideways_in_kerf", "The hand leans from side to side while the tool rotates in its kerf.", Sideways);
  Add(all, "tilt_in_kerf", "Spindle stopped, the hand tilts the tool in its kerf by 3 degrees and back.", Tilt);
  Add(all, "break_through", "The hand pushes the tool through the bone and out on the other side.", BreakThrough);
  Add(all, "spindle_changes", "The spindle is reversed, stopped and started in the cut, each within one tick.",
      SpindleChanges);
  Add(all, "any_hand", "Random hands within the range of measured hands push the tool into the bone.", AnyHand);
}

}  // namespace kerf
