// The stability of a scene's loop: the examination of `kerf stability`.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/stability/margins.h"
#include "experiment/stability/scenarios.h"
#include "experiment/stability_study/stability_subject.h"
#include "session/run/loop_setup.h"
#include "session/scene/scene.h"

namespace kerf {

/// Margins that a loop must have with its own hand to be called stable.
inline constexpr double kMinGainMargin = 2;
inline constexpr int kMinDelayMargin_ticks = 1;

struct StabilityOptions {
  bool quick = false;     // only the scene's hand and the released one, and a coarser map
  bool as_asked = false;  // the scene's coupling without lowering it to the limits of device and loop
  std::uint64_t seed = 1;
  int threads = 0;                          // 0: number of the machine's cores
  const std::atomic<bool>* stop = nullptr;  // ends the examination early; may be null
};

/// The margins of one hand in one state, with the coupling that is used with the scene's own hand.
struct HandMargins {
  std::string hand;
  bool own = false;  // true for the scene's own hand
  HeldState state = HeldState::kStoppedOnBone;
  bool linear = false;  // without the device's friction and the encoder's steps
  bool done = false;    // false: the examination ended before these margins were found
  Margins margins;
  /// Compares with the requirement: kMinGainMargin and kMinDelayMargin_ticks for the scene's own hand, and stability
  /// without margins for any other hand. Nothing is required of other hands in the linear loop, or of a released handle
  /// (H0) that is not the scene's hand.
  Judgement judgement() const;
};

/// Limits according to the device and to the rule for a sampled spring, in the units of the map, which are those of the
/// simulation.
struct MapLimits {
  double max_stiffness_N_per_mm = 0;  // that the device can bear; infinite if the profile states no limit
  double max_damping_Ns_per_mm = 0;
  double own_damping_Ns_per_mm = 0;  // of device and hand
  double per_s = 0;                  // 2 / (T + 2 t_d)
  /// Returns the maximum stable stiffness, N/mm, at a damping B of the coupling. The rule is K = 2 (b + B) / (T + 2
  /// t_d).
  double CalcRule(double B_Ns_per_mm) const { return (own_damping_Ns_per_mm + B_Ns_per_mm) * per_s; }
};

struct StabilityStudy {
  std::string scene;  // name of the file, without folder and extension
  std::string title;
  std::string command;  // command that reproduces this study from the resolved scene, which is one of the result files
  std::string tool;     // for the user
  double rate_hz = 0;
  double rpm = 0;
  std::string rate;  // for the user, such as "7500 rpm"
  double voxel_mm = 0;
  bool quick = false;
  std::uint64_t seed = 1;
  LoopSetup setup;
  FirstTouch touch;
  std::vector<ScenarioResult> scenarios;
  std::vector<HandMargins> margins;
  HeldState map_state = HeldState::kStoppedOnBone;
  StabilityMap map;                   // with the real device and the scene's hand
  std::vector<Behaviour> map_linear;  // at the same points, without the device's friction and encoder steps
  MapLimits limits;
  bool complete = true;               // false: ended before everything was examined
  std::vector<std::string> findings;  // causes of instability, a phrase each
  std::vector<std::string> warnings;  // a sentence each
  double wall_s = 0;
  std::vector<std::string> files;  // written by WriteStabilityStudy

  /// Numbers of required checks: all, those that could be judged, and those that failed.
  struct Count {
    int asked = 0;
    int judged = 0;
    int broken = 0;
  };
  Count CountScenarios() const;
  Count CountMargins() const;
  /// Returns true if the study is complete, something was judged and no check failed.
  bool stable() const { return complete && findings.empty() && CountScenarios().judged + CountMargins().judged > 0; }
};

/// Receives the current stage (for a progress bar) and the fraction done, 0..1. Called from any thread.
using StabilityProgress = std::function<void(const std::string& stage, double fraction)>;

/// Throws Error for slab mode, a stopped spindle, an unknown device or hand, a path that does not enter the bone
/// (FindFirstTouch), or a parameter out of range.
StabilityStudy ExamineStability(const Scene& scene, const StabilityOptions& options, const StabilityProgress& progress);

/// Fills `findings` from the results.
void JudgeStability(StabilityStudy& study);

/// Returns the ratio of a figure to its bound; above 1, the bound is violated. NaN violates all bounds. A figure that
/// the loop itself limits to its bound is never near it.
double CalcNearness(const StabilityFigure& figure);
/// Returns the scenario's figure that is nearest to its bound, or null if the scenario has no figures.
const StabilityFigure* FindNearest(const ScenarioResult& scenario);
struct WorstFigure {
  const ScenarioResult* scenario = nullptr;
  const StabilityFigure* figure = nullptr;
};
/// Returns the worst figure of each scenario that was run, worst scenario first.
std::vector<WorstFigure> RankScenarios(const StabilityStudy& study);

/// Compares with the requirement for a device with the hand that its coupling was fitted to: kMinGainMargin and
/// kMinDelayMargin_ticks in every state. Nothing is required of a released handle.
Judgement Judge(const ProfileMargins& row);
/// Computes the margins of each device of the built-in table with each hand, for the scene's bone, tool, gains and
/// rate. The scene's device and hand are ignored. If ended early, returns the results so far and sets `complete` (may
/// be null) to false.
std::vector<ProfileMargins> ExamineProfiles(const Scene& scene, const StabilityOptions& options,
                                            const StabilityProgress& progress, bool* complete = nullptr);

}  // namespace kerf
