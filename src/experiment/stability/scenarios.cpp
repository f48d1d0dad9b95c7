#include "experiment/stability/scenarios.h"

#include <algorithm>

#include "experiment/stability/scenario_run.h"

namespace kerf {

bool ScenarioResult::holds() const {
  return skipped || std::all_of(figures.begin(), figures.end(), [](const StabilityFigure& f) { return f.holds(); });
}

Judgement ScenarioResult::judgement() const {
  if (skipped) return Judgement::kNotAsked;
  if (!holds()) return Judgement::kBroken;
  if (!unjudged.empty()) return Judgement::kNotJudged;
  return figures.empty() ? Judgement::kBroken : Judgement::kHolds;
}

const std::vector<Scenario>& Scenarios() {
  static const std::vector<Scenario> all = [] {
    std::vector<Scenario> list;
    AddContactScenarios(list);
    AddCuttingScenarios(list);
    AddFaultScenarios(list);
    return list;
  }();
  return all;
}

}  // namespace kerf
