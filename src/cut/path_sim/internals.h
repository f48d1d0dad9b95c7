// What kerf's own sources use of a simulation on a path, in addition to its public functions.
#pragma once

#include "cut/effects/plan.h"
#include "kerf/simulation.h"

namespace kerf {

struct SimulationInternals {
  static EffectPlan& Effects(const Simulation& simulation);
};

/// State and results of the effects.
inline EffectPlan& EffectsOf(Simulation& simulation) {
  return SimulationInternals::Effects(simulation);
}
inline const EffectPlan& EffectsOf(const Simulation& simulation) {
  return SimulationInternals::Effects(simulation);
}

}  // namespace kerf
