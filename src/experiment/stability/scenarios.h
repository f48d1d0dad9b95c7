// The situations in which a saw in a hand must stay steady, each run on a subject of one's choice.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/stability/margins.h"

namespace kerf {

/// A figure that was measured, and what it must not pass.
struct StabilityFigure {
  std::string name;  // "noise above 20 Hz"
  std::string unit;  // "mN"
  double value = 0;
  double bound = 0;
  bool at_most = true;   // false: at least
  bool clamped = false;  // the loop itself cuts it off at the bound: to come near is no worry
  bool holds() const { return at_most ? value <= bound : value >= bound; }  // not for NaN
};

struct ScenarioResult {
  std::string name;      // "press_and_hold"
  std::string what;      // a sentence for people
  bool skipped = false;  // does not apply to this subject; `what` says why
  /// Why it, or some of it, could not be judged here; a sentence. Empty when all was.
  std::string unjudged;
  /// When the tool came out behind the bone, s since the start: from then on nothing is cut and no noise is judged.
  std::optional<double> cut_through_s;
  std::vector<StabilityFigure> figures;
  // The run's force on the device, for a figure
  std::vector<double> time_s;
  std::vector<double> force_N;
  bool holds() const;  // no figure is broken
  /// kNotAsked: skipped.
  Judgement judgement() const;
};

struct Scenario {
  const char* name;
  const char* what;
  std::function<ScenarioResult(const StabilitySubject& subject, std::uint64_t seed)> run;
};
/// In the order in which they are reported.
const std::vector<Scenario>& Scenarios();

}  // namespace kerf
