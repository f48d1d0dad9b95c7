// Whether a scene's loop is stable: what `kerf stability` examines.
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

/// What a loop must have to be called stable, with its own hand.
inline constexpr double kLeastGainMargin = 2;
inline constexpr int kLeastDelayMargin_ticks = 1;
/// FindMargins() tries no more.
inline constexpr int kMostDelayMargin_ticks = 16;

struct StabilityOptions {
  bool quick = false;     // the scene's hand and the released one, and a coarser map
  bool as_asked = false;  // the scene's coupling without lowering it to what device and loop bear
  std::uint64_t seed = 1;
  int threads = 0;                          // 0: as many as the machine has
  const std::atomic<bool>* stop = nullptr;  // ends it early; may be null
};

/// How far one hand is from swinging, in one state. The coupling is the one that the scene's own hand is given.
struct HandMargins {
  std::string hand;
  bool own = false;  // the scene's
  HeldState state = HeldState::kStoppedOnBone;
  bool linear = false;  // without the device's friction and the encoder's steps
  bool done = false;    // false: it was ended before
  Margins margins;
  /// What is asked of it: of the scene's hand the margins above, of another that it is stable as it is, of a handle
  /// that is let go of (H0, where it is not the scene's) nothing.
  Judgement judgement() const;
};

/// What the device and the rule for a sampled spring say, in the map's units: the simulation's.
struct MapLimits {
  double most_stiffness_N_per_mm = 0;  // that the device bears; infinite when it says nothing
  double most_damping_Ns_per_mm = 0;
  double own_damping_Ns_per_mm = 0;  // of device and hand
  double per_s = 0;                  // 2 / (T + 2 t_d)
  /// Greatest stiffness, N/mm, that is stable by the rule K = 2 (b + B) / (T + 2 t_d) at a damping B of the coupling.
  double CalcRule(double B_Ns_per_mm) const { return (own_damping_Ns_per_mm + B_Ns_per_mm) * per_s; }
};

struct StabilityStudy {
  std::string scene;  // name of the file, without folder and extension
  std::string title;
  std::string command;  // that makes this again, of the resolved scene among the results
  std::string tool;     // for people
  double rate_hz = 0;
  double rpm = 0;
  double voxel_mm = 0;
  bool quick = false;
  std::uint64_t seed = 1;
  LoopSetup setup;
  FirstTouch touch;
  std::vector<ScenarioResult> scenarios;
  std::vector<HandMargins> margins;
  HeldState map_state = HeldState::kStoppedOnBone;
  StabilityMap map;                   // as the device is, with the scene's hand
  std::vector<Behaviour> map_linear;  // at the same points, without its friction and encoder steps
  MapLimits limits;
  bool complete = true;               // false: it was ended before all was examined
  std::vector<std::string> findings;  // what is not stable, a phrase each
  std::vector<std::string> warnings;  // a sentence each
  double wall_s = 0;
  std::vector<std::string> files;  // that WriteStabilityStudy wrote

  /// Of what was asked: how much, how much of that could be judged, and how much was broken.
  struct Count {
    int asked = 0;
    int judged = 0;
    int broken = 0;
  };
  Count CountScenarios() const;
  Count CountMargins() const;
  /// Nothing that was examined is broken, and something was.
  bool stable() const { return complete && findings.empty() && CountScenarios().judged + CountMargins().judged > 0; }
};

/// What is being done (for a progress bar) and how much of it, 0..1. Any thread.
using StabilityProgress = std::function<void(const std::string& stage, double fraction)>;

/// Throws Error: slab mode, a spindle that stands still, no such device or hand, a path that does not lead into the
/// bone (FindFirstTouch), a parameter out of range.
StabilityStudy ExamineStability(const Scene& scene, const StabilityOptions& options, const StabilityProgress& progress);

/// Fills `findings` from what was found.
void JudgeStability(StabilityStudy& study);

/// How near a figure is to its bound: above 1 it is broken. NaN is beyond all bounds; what the loop cuts off at its
/// bound is never near.
double CalcNearness(const StabilityFigure& figure);
/// Null when it has no figures.
const StabilityFigure* FindNearest(const ScenarioResult& scenario);
struct WorstFigure {
  const ScenarioResult* scenario = nullptr;
  const StabilityFigure* figure = nullptr;
};
/// The worst figure of each scenario that was run, worst scenario first.
std::vector<WorstFigure> RankScenarios(const StabilityStudy& study);

/// What is asked of a device in the hand that its coupling was fitted to: the margins above, in every state. Let go of:
/// nothing, as above.
Judgement Judge(const ProfileMargins& row);
/// Margins of each device of the built-in table in each hand, with the scene's bone, tool, gains and rate. What the
/// scene says of device and hand is not looked at. Ended before: what was done till then, `complete` (may be null) is
/// false.
std::vector<ProfileMargins> ExamineProfiles(const Scene& scene, const StabilityOptions& options,
                                            const StabilityProgress& progress, bool* complete = nullptr);

}  // namespace kerf
