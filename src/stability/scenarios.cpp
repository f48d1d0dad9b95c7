#include "stability/scenarios.h"

#include <algorithm>

#include "stability/scenario_run.h"

namespace kerf {

bool ScenarioResult::holds() const {
  return skipped || std::all_of(figures.begin(), figures.end(), [](const StabilityFigure& f) { return f.holds(); });
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
