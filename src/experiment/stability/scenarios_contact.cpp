// Scenarios with a stopped spindle: the tool rests on the bone, hits it, and moves in and out of it.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "experiment/stability/measures.h"
#include "experiment/stability/scenario_run.h"

namespace kerf {
namespace {

/// Returns the maximum permitted depth of a stopped tool's edge in the bone: half a voxel, which is the motion in a
/// substep, and a small tolerance.
double CalcBuriedBound_mm(const StabilitySubject& subject) {
  return 0.5 * subject.bone.voxel_mm() + 0.05;
}

ScenarioResult PressAndHold(const StabilitySubject& subject, const Scenario& scenario, double simulated_N) {
  ScenarioRun run(subject, scenario);
  run.set_rpm(0);
  run.AwaitRamp();
  const double push_N = run.CalcPush_N(simulated_N);
  // On an edge the tool is pushed along the contact normal, because along the feed it would slide off.
  run.Lean(push_N * HoldTool(subject, HeldState::kStoppedOnBone).push_W);
  run.Run(1.5);
  const std::size_t early = run.now();
  run.Run(1);
  const std::size_t late = run.now();
  run.Run(1);
  const double buried_mm = CalcBuried(subject.bone, subject.setup.coupled.tool, run.tick().out.coupled.X_WT);
  if (run.IsOff(1) && run.tick().out.faults == 0 && !(buried_mm > 0)) {
    run.LeaveUnjudged("The tool slid off the bone: the path meets an edge there.");
    return run.Finish();
  }
  run.AtLeast("force", "N", run.MeanForce_N(late), 0.3 * (push_N - subject.setup.profile.friction_N));
  run.AddNoise(late);
  const double bound_N = std::max(0.02, 0.01 * run.MeanForce_N(late));
  const Oscillation swing = FindOscillation(run.ForcesAlong_N(subject.into_W, late), run.T(), bound_N);
  run.AtMost("sustained oscillation", "", swing.is_limit_cycle ? 1 : 0, 0);
  // A hand with little damping still rings from the onset of the push, in some cases about once a second. This ringing
  // must not grow.
  const double before_um = 1000 * CalcAliveness(run.positions_mm(early, late), run.T());
  const double step_um = subject.setup.quantise ? 1000 * subject.setup.profile.resolution_mm : 0;
  run.AtMost("motion from 1 to 20 Hz", "um", 1000 * CalcAliveness(run.positions_mm(late), run.T()),
             std::max({step_um, 1.25 * before_um, 0.1}));
  run.AtMost("depth of the edge in the bone", "mm", buried_mm, CalcBuriedBound_mm(subject));
  run.AddEnergy();
  return run.Finish();
}

/// The tool is thrown at the bone. In flight the hand acts only with its mass and damping.
ScenarioResult Blow(const StabilitySubject& subject, const Scenario& scenario, double speed_mm_per_s, double rpm) {
  const Pose start = BackOff(subject, 4);
  ScenarioRun run(subject, scenario, subject.bone, start);
  run.set_rpm(rpm);
  run.AwaitRamp();
  const double room_mm = glm::dot(subject.X_WT_start.p_AB - start.p_AB, subject.into_W);
  const double mass = 1e-3 * (subject.setup.profile.mass_kg + subject.setup.hand.mass_kg);
  const double throw_mm = std::max(0.7 * room_mm, 0.1);
  const double push_N = mass * speed_mm_per_s * speed_mm_per_s / (2 * throw_mm) + subject.setup.profile.friction_N;
  const Vec3 p_start = start.Point(subject.setup.coupled.coupling.p_TC_mm);
  double arrived = 0;
  double back = 0;
  double deepest_mm = -1;
  bool thrown = false;
  bool touched = false;
  for (int i = 0; i < static_cast<int>(1 / run.T()); ++i) {
    if (!touched) {
      // The hand moves along with the handle.
      const double way_mm = glm::dot(run.tick().p_WC_mm - p_start, subject.into_W);
      thrown = thrown || way_mm > throw_mm || arrived > speed_mm_per_s;
      Intention intention{.X_WH = start, .v_W_mm_per_s = run.tick().v_WC_mm_per_s};
      intention.X_WH.p_AB += run.tick().p_WC_mm - p_start;
      if (!thrown) intention.push_W_N = push_N * subject.into_W;
      run.loop().device().SetIntention(intention);
    }
    const ClosedLoopTick& tick = run.Step();
    const double into = glm::dot(tick.v_WC_mm_per_s, subject.into_W);
    if (!touched && tick.f_device_N != Vec3(0)) {
      touched = true;
      Intention intention{.X_WH = start};
      intention.X_WH.p_AB += tick.p_WC_mm - p_start;
      run.loop().device().SetIntention(intention);
    }
    if (!touched) arrived = std::max(arrived, into);
    if (touched) back = std::max(back, -into);
    if (rpm == 0 && touched && i % 8 == 0) {
      deepest_mm = std::max(deepest_mm, CalcBuried(subject.bone, subject.setup.coupled.tool, tick.out.coupled.X_WT));
    }
  }
  run.AtLeast("impact speed", "mm/s", arrived, 0.3 * speed_mm_per_s);
  if (arrived > 0) run.AtMost("ratio of rebound speed to impact speed", "", back / arrived, 1);
  if (rpm == 0) run.AtMost("depth of the edge in the bone, maximum", "mm", deepest_mm, CalcBuriedBound_mm(subject));
  return run.Finish();
}

/// The hand moves in random orbits, in and out of the bone, and back to the start.
ScenarioResult Orbits(const StabilitySubject& subject, const Scenario& scenario, std::uint64_t seed) {
  const HandModel& hand = subject.setup.hand;
  if (hand.stiffness_N_per_mm <= 0) return ScenarioRun::Skip(scenario, "no hand moves a released device.");
  ScenarioRun run(subject, scenario);
  run.set_rpm(0);
  run.AwaitRamp();
  std::mt19937_64 random(seed);
  const auto draw = [&](double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  constexpr int kWaves = 4;
  constexpr double kSeconds = 4;  // duration of an orbit, a whole number of periods of each wave
  const double deep_mm =
      std::min(2.0, run.CalcPush_N(10) / (run.scale() * subject.setup.coupled.coupling.stiffness_N_per_mm));
  // With a soft hand the target must be further away for the handle to overcome the device's friction.
  const double wanted_mm = deep_mm + 3 * subject.setup.profile.friction_N / hand.stiffness_N_per_mm;
  struct Wave {
    Vec3 amplitude_mm;
    double Hz;
    double phase;
  };
  std::vector<Wave> waves;
  for (int i = 0; i < kWaves; ++i) {
    const double turns = std::floor(draw(1, 8 * kSeconds));
    const Vec3 across(draw(-1, 1), draw(-1, 1), draw(-1, 1));
    waves.push_back({wanted_mm / kWaves * (1.5 * draw(-1, 1) * subject.into_W + 0.5 * across), turns / kSeconds,
                     draw(0, 2 * std::numbers::pi)});
  }
  const int ticks = static_cast<int>(std::lround(kSeconds / run.T()));
  for (int i = 0; i < ticks; ++i) {
    const double t = i * run.T();
    const double ease = std::min({1.0, t / 0.5, (kSeconds - t) / 0.5});
    Intention intention{.X_WH = run.X_WT_start()};
    intention.X_WH.p_AB += ease * (0.6 * wanted_mm) * subject.into_W;
    for (const Wave& w : waves) {
      intention.X_WH.p_AB += ease * std::sin(2 * std::numbers::pi * w.Hz * t + w.phase) * w.amplitude_mm;
      intention.v_W_mm_per_s +=
          ease * 2 * std::numbers::pi * w.Hz * std::cos(2 * std::numbers::pi * w.Hz * t + w.phase) * w.amplitude_mm;
    }
    run.loop().device().SetIntention(intention);
    run.Step();
  }
  run.loop().device().SetIntention({.X_WH = run.X_WT_start()});
  run.Run(0.5);
  run.AtLeast("energy exchanged", "mJ", run.tick().energy.exchanged_mJ, 1e-6);
  run.AddEnergy();
  return run.Finish();
}

}  // namespace

void AddContactScenarios(std::vector<Scenario>& all) {
  const auto press = [](double simulated_N) {
    return [=](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
      return PressAndHold(subject, scenario, simulated_N);
    };
  };
  Add(all, "press_1N", "Spindle stopped, the hand presses the tool against the bone with 1 N and holds still.",
      press(1));
  Add(all, "press_5N", "The same with 5 N.", press(5));
  Add(all, "press_20N", "The same with 20 N, or the device's continuous force if lower.", press(20));
  const auto blow = [](double speed_mm_per_s, bool turning) {
    return [=](const StabilitySubject& subject, const Scenario& scenario, std::uint64_t) {
      if (turning && std::abs(subject.rpm) < 1) return ScenarioRun::Skip(scenario, "the spindle is stopped.");
      return Blow(subject, scenario, speed_mm_per_s, turning ? subject.rpm : 0);
    };
  };
  Add(all, "blow_50mm_per_s", "Spindle stopped, the tool is thrown at the bone at 50 mm/s.", blow(50, false));
  Add(all, "blow_200mm_per_s", "The same at 200 mm/s.", blow(200, false));
  Add(all, "blow_500mm_per_s", "The same at 500 mm/s.", blow(500, false));
  Add(all, "blow_turning_50mm_per_s", "The rotating tool is thrown at the bone at 50 mm/s.", blow(50, true));
  Add(all, "blow_turning_500mm_per_s", "The same at 500 mm/s.", blow(500, true));
  Add(all, "orbits", "Spindle stopped, the hand moves in orbits in and out of the bone and back to the start.", Orbits);
}

}  // namespace kerf
