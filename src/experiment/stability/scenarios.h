// The situations in which a loop with a hand-held saw must stay steady. Each can be run on any subject.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "experiment/stability/margins.h"

namespace kerf {

/// A measured figure and its bound.
struct StabilityFigure {
  std::string name;  // "noise above 20 Hz"
  std::string unit;  // "mN"
  double value = 0;
  double bound = 0;
  bool at_most = true;   // false: at least
  bool clamped = false;  // the loop itself limits it to the bound, so being close to it is no concern
  bool holds() const { return at_most ? value <= bound : value >= bound; }  // false for NaN
};

struct ScenarioResult {
  std::string name;      // "press_and_hold"
  std::string what;      // a sentence for the user
  bool skipped = false;  // does not apply to this subject; `what` states why
  /// Reason why the scenario, or part of it, could not be judged here, as a sentence. Empty if all was judged.
  std::string unjudged;
  /// Time at which the tool came out on the far side of the bone, s since the start. Afterwards nothing is cut and no
  /// noise is judged.
  std::optional<double> cut_through_s;
  std::vector<StabilityFigure> figures;
  // Force on the device during the run, for a diagram
  std::vector<double> time_s;
  std::vector<double> force_N;
  bool holds() const;  // no bound is violated
  /// Returns kNotAsked if the scenario was skipped.
  Judgement judgement() const;
};

struct Scenario {
  const char* name;
  const char* what;
  std::function<ScenarioResult(const StabilitySubject& subject, std::uint64_t seed)> run;
};
/// Returns all scenarios, in the order of the report.
const std::vector<Scenario>& Scenarios();

}  // namespace kerf
