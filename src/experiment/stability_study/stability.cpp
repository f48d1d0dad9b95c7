#include "experiment/stability_study/stability.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <string_view>

#include "device/devices/profiles.h"
#include "experiment/stability/held_tool.h"
#include "kerf/error.h"
#include "session/run/bone_cache.h"
#include "session/run/make_bone.h"
#include "session/run/work_list.h"
#include "session/scene/saws.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

/// The released handle. Nothing pushes a handle without a hand, so its margins are shown but not required. The scenario
/// in which a hand lets go shows its behaviour.
constexpr std::string_view kReleasedHand = "H0";

// Approximate time of one scenario, one margin and one point of the map on one core, s; used only to show the progress.
constexpr double kScenarioCost = 4;
constexpr double kMarginCost = 1;
constexpr double kPointCost = 0.05;

/// Stiffness and damping of a map: the range includes the scene's own values and extends beyond the rule's limit.
struct MapAxes {
  std::vector<double> stiffness_N_per_mm;
  std::vector<double> damping_Ns_per_mm;
};

std::vector<double> SpaceOut(double from, double to, int count, bool log) {
  std::vector<double> values;
  for (int i = 0; i < count; ++i) {
    const double fraction = count > 1 ? static_cast<double>(i) / (count - 1) : 0;
    values.push_back(log ? from * std::pow(to / from, fraction) : from + fraction * (to - from));
  }
  return values;
}

MapAxes MakeMapAxes(const CouplingParams& coupling, const MapLimits& limits, bool quick) {
  constexpr double kMinStiffness = 1e-3;  // these three are the limits of CouplingParams
  constexpr double kMaxStiffness = 1000;
  constexpr double kMaxDamping = 1;
  const double rule = limits.CalcRule(coupling.damping_Ns_per_mm);
  const double K = coupling.stiffness_N_per_mm;
  MapAxes axes;
  axes.stiffness_N_per_mm = SpaceOut(std::max(std::min(K, rule) / 4, kMinStiffness),
                                     std::min(8 * std::max(K, rule), kMaxStiffness), quick ? 9 : 15, true);
  const double device = std::isfinite(limits.max_damping_Ns_per_mm) ? limits.max_damping_Ns_per_mm : 0;
  const double max_damping = std::max({2 * coupling.damping_Ns_per_mm, 1.5 * device, limits.own_damping_Ns_per_mm});
  axes.damping_Ns_per_mm = SpaceOut(0, std::min(max_damping, kMaxDamping), quick ? 5 : 11, false);
  return axes;
}

MapLimits MakeMapLimits(const LoopSetup& setup, double rate_hz) {
  MapLimits limits;
  limits.max_stiffness_N_per_mm = setup.fitted.limits.stiffness_N_per_mm;
  limits.max_damping_Ns_per_mm = setup.fitted.limits.damping_Ns_per_mm;
  limits.own_damping_Ns_per_mm =
      (setup.profile.own_damping_Ns_per_mm + setup.hand.damping_Ns_per_mm) / setup.force_scale;
  limits.per_s = 2 * rate_hz;
  return limits;
}

std::string ShowMargin(const Margins& margins) {
  return fmt::format("{}{:.3g}", margins.gain_beyond ? "more than " : "", margins.gain);
}

void CheckScene(const Scene& scene) {
  if (scene.simulation.mode == SceneMode::kSlab) {
    throw Error(
        "[simulation] mode = \"slab\" has no tool coupled to a handle; set mode = \"voxel\" for 'kerf stability'");
  }
  if (scene.tool.rpm < 1) {
    throw Error(
        "[tool] rpm = 0: a stopped tool cuts nothing; set the speed for cutting; 'kerf stability' also tests the "
        "stopped tool");
  }
}

/// Brings the tool into place for each state. Returns false if ended early.
bool HoldInEveryState(const StabilitySubject& subject, const StabilityOptions& options,
                      const StabilityProgress& progress, std::array<HeldTool, kHeldStates.size()>& held) {
  WorkList work;
  for (std::size_t i = 0; i < held.size(); ++i) {
    work.Add("moving the tool into place", 1, [&, i] { held[i] = HoldTool(subject, kHeldStates[i]); });
  }
  return work.Run(options.threads, options.stop, progress);
}

}  // namespace

Judgement HandMargins::judgement() const {
  if (own) return margins.Judge(kMinGainMargin, kMinDelayMargin_ticks);
  if (linear || hand == kReleasedHand) return Judgement::kNotAsked;
  return margins.Judge(1, 0);
}

StabilityStudy::Count StabilityStudy::CountScenarios() const {
  Count count;
  for (const ScenarioResult& scenario : scenarios) {
    const Judgement judgement = scenario.judgement();
    if (judgement == Judgement::kNotAsked) continue;
    ++count.asked;
    if (judgement != Judgement::kNotJudged) ++count.judged;
    if (judgement == Judgement::kBroken) ++count.broken;
  }
  return count;
}

StabilityStudy::Count StabilityStudy::CountMargins() const {
  Count count;
  for (const HandMargins& m : margins) {
    const Judgement judgement = m.judgement();
    if (!m.done || judgement == Judgement::kNotAsked) continue;
    ++count.asked;
    if (judgement != Judgement::kNotJudged) ++count.judged;
    if (judgement == Judgement::kBroken) ++count.broken;
  }
  return count;
}

double CalcNearness(const StabilityFigure& f) {
  constexpr double kBeyond = std::numeric_limits<double>::infinity();
  if (std::isnan(f.value) || std::isnan(f.bound)) return kBeyond;
  // A figure that the loop limits, or one whose bound is zero, is not near its bound.
  if (f.holds() && (f.clamped || (f.at_most ? f.value : f.bound) <= 0)) return 0;
  const double fraction = f.at_most ? f.value / f.bound : f.bound / f.value;
  // For a bound of 0 or below there is no such ratio.
  if (!(fraction >= 0)) return f.holds() ? 0 : kBeyond;
  return f.holds() ? std::min(fraction, 1.0) : std::max(fraction, std::nextafter(1.0, 2.0));
}

const StabilityFigure* FindNearest(const ScenarioResult& scenario) {
  const auto nearest = std::max_element(
      scenario.figures.begin(), scenario.figures.end(),
      [](const StabilityFigure& a, const StabilityFigure& b) { return CalcNearness(a) < CalcNearness(b); });
  return nearest == scenario.figures.end() ? nullptr : &*nearest;
}

std::vector<WorstFigure> RankScenarios(const StabilityStudy& study) {
  std::vector<WorstFigure> ranked;
  for (const ScenarioResult& scenario : study.scenarios) {
    const StabilityFigure* nearest = scenario.skipped ? nullptr : FindNearest(scenario);
    if (nearest) ranked.push_back({&scenario, nearest});
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const WorstFigure& a, const WorstFigure& b) {
    return CalcNearness(*a.figure) > CalcNearness(*b.figure);
  });
  return ranked;
}

void JudgeStability(StabilityStudy& study) {
  study.findings.clear();
  for (const ScenarioResult& scenario : study.scenarios) {
    if (scenario.judgement() != Judgement::kBroken) continue;
    std::string broken;
    for (const StabilityFigure& f : scenario.figures) {
      if (f.holds()) continue;
      broken += fmt::format("{}{} is {:.3g}{}{}, but must be {} {:.3g}", broken.empty() ? "" : "; ", f.name, f.value,
                            f.unit.empty() ? "" : " ", f.unit, f.at_most ? "at most" : "at least", f.bound);
    }
    study.findings.push_back(
        fmt::format("{}: {}", scenario.name, broken.empty() ? "nothing could be measured" : broken));
  }
  for (const HandMargins& m : study.margins) {
    if (!m.done || m.judgement() != Judgement::kBroken) continue;
    const std::string where = fmt::format("{} in the hand {}{}", ToString(m.state), m.hand,
                                          m.linear ? ", without friction and encoder steps" : "");
    if (!m.own) {
      study.findings.push_back(
          fmt::format("{}: it is not stable with this coupling (gain margin {})", where, ShowMargin(m.margins)));
    } else if (m.margins.gain < kMinGainMargin && !m.margins.gain_beyond) {
      study.findings.push_back(fmt::format("{}: the gain margin is {}, at least {:g} required", where,
                                           ShowMargin(m.margins), kMinGainMargin));
    } else {
      study.findings.push_back(fmt::format("{}: it tolerates {} ticks of additional delay, at least {} required", where,
                                           m.margins.delay_ticks, kMinDelayMargin_ticks));
    }
  }
}

StabilityStudy ExamineStability(const Scene& scene, const StabilityOptions& options,
                                const StabilityProgress& progress) {
  CheckScene(scene);
  const auto began = std::chrono::steady_clock::now();
  StabilityStudy study;
  study.scene = scene.name;
  study.title = scene.title;
  study.tool = DescribeTool(scene.tool.shape);
  study.rate_hz = scene.loop.rate_hz;
  study.rpm = scene.tool.rpm;
  study.rate = DescribeRate(scene.tool);
  study.quick = options.quick;
  study.seed = options.seed;
  study.setup = MakeLoopSetup(scene);
  if (options.as_asked) {
    study.setup.fitted.coupling = MakeCoupledParams(scene).coupling;
    study.setup.fitted.lowered = {};
  }
  study.command = fmt::format("kerf stability scene.toml -o again{}{} --seed {}", options.quick ? " --quick" : "",
                              options.as_asked ? " --as-asked" : "", options.seed);

  MaterialSummary material;
  const Bone bone = MakeSceneBone(
      scene,
      [&](double f) {
        if (progress) progress("making the bone", f);
      },
      &material);
  FinishKeepingBones();
  study.voxel_mm = bone.voxel_mm();
  study.warnings = FindToolWarnings(scene, bone.voxel_mm());
  for (const std::string& warning : FindHandWarnings(scene, study.setup)) study.warnings.push_back(warning);
  study.warnings.insert(study.warnings.end(), material.warnings.begin(), material.warnings.end());
  study.touch = FindFirstTouch(scene, bone);
  const StabilitySubject subject = MakeStabilitySubject(scene, study.setup, bone, study.touch);

  std::array<HeldTool, kHeldStates.size()> held;
  study.complete = HoldInEveryState(subject, options, progress, held);
  WorkList work;
  const std::vector<Scenario>& scenarios = Scenarios();
  study.scenarios.resize(scenarios.size());
  for (std::size_t i = 0; i < scenarios.size(); ++i) {
    study.scenarios[i].name = scenarios[i].name;
    study.scenarios[i].what = "The study ended before this scenario.";
    study.scenarios[i].skipped = true;
    work.Add("scenarios", kScenarioCost, [&, i] { study.scenarios[i] = scenarios[i].run(subject, options.seed); });
  }

  const std::string& own = study.setup.hand.name;
  for (const HandModel& hand : HandModels()) {
    if (options.quick && hand.name != own && hand.name != "H0") continue;
    for (const HeldState state : kHeldStates) {
      for (const bool linear : {false, true}) {
        study.margins.push_back({hand.name, hand.name == own, state, linear, false, {}});
      }
    }
  }
  for (HandMargins& m : study.margins) {
    work.Add("margins", kMarginCost, [&subject, &held, &m] {
      ClosedLoopSetup setup = subject.setup;
      setup.hand = FindHandModel(m.hand);
      m.margins = FindHeldMargins(held[static_cast<std::size_t>(m.state)], setup, m.linear);
      m.done = true;
    });
  }

  study.limits = MakeMapLimits(study.setup, study.rate_hz);
  const MapAxes axes = MakeMapAxes(study.setup.fitted.coupling, study.limits, options.quick);
  const std::size_t width = axes.stiffness_N_per_mm.size();
  const std::size_t points = axes.damping_Ns_per_mm.size() * width;
  std::array<std::vector<Behaviour>, 2> behaviour;  // with the real device, and linear
  for (const bool linear : {false, true}) {
    std::vector<Behaviour>& of = behaviour[linear ? 1 : 0];
    of.resize(points);
    for (std::size_t i = 0; i < points; ++i) {
      work.Add("map", kPointCost, [&, i, linear] {
        ClosedLoopSetup setup = subject.setup;
        setup.coupled.coupling.stiffness_N_per_mm = axes.stiffness_N_per_mm[i % width];
        setup.coupled.coupling.damping_Ns_per_mm = axes.damping_Ns_per_mm[i / width];
        of[i] = TryHeld(held[static_cast<std::size_t>(study.map_state)], setup, linear);
      });
    }
  }

  study.complete = study.complete && work.Run(options.threads, options.stop, progress);
  // An incomplete map is not returned.
  if (study.complete) {
    study.map = {axes.stiffness_N_per_mm, axes.damping_Ns_per_mm, behaviour[0]};
    study.map_linear = behaviour[1];
  }
  JudgeStability(study);
  study.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return study;
}

Judgement Judge(const ProfileMargins& row) {
  if (row.hand != row.fitted_to) return Judgement::kNotAsked;
  Judgement all = Judgement::kHolds;
  for (const Margins& m : row.margins) {
    const Judgement one = m.Judge(kMinGainMargin, kMinDelayMargin_ticks);
    if (one == Judgement::kBroken) return one;
    if (one == Judgement::kNotJudged) all = one;
  }
  return all;
}

std::vector<ProfileMargins> ExamineProfiles(const Scene& scene, const StabilityOptions& options,
                                            const StabilityProgress& progress, bool* complete) {
  CheckScene(scene);
  const Bone bone = MakeSceneBone(scene, [&](double f) {
    if (progress) progress("making the bone", f);
  });
  FinishKeepingBones();
  LoopSetup asked = MakeLoopSetup(scene);
  asked.fitted.coupling = MakeCoupledParams(scene).coupling;  // starting point for fitting the coupling to each device
  const StabilitySubject subject = MakeStabilitySubject(scene, asked, bone, FindFirstTouch(scene, bone));
  const std::vector<DeviceProfile>& profiles = DeviceProfiles();
  std::vector<std::vector<ProfileMargins>> by_profile(profiles.size());
  WorkList work;
  for (std::size_t i = 0; i < profiles.size(); ++i) {
    work.Add("margins of every device", 1,
             [&, i] { by_profile[i] = CalcProfileMargins(subject, {profiles[i]}, {}, options.stop); });
  }
  work.Run(options.threads, options.stop, progress);
  if (complete != nullptr) *complete = options.stop == nullptr || !options.stop->load();
  std::vector<ProfileMargins> all;
  for (const std::vector<ProfileMargins>& rows : by_profile) all.insert(all.end(), rows.begin(), rows.end());
  return all;
}

}  // namespace kerf
