// Simulation of measured quantities from a force law alone (docs/validation.md gives the formulas).
#pragma once

#include <string>
#include <string_view>

#include "experiment/validation/law_access.h"
#include "experiment/validation/measured_set.h"

namespace kerf {

/// A simulated quantity; if it could not be simulated, kNotGiven and the reason, in words.
struct Simulated {
  double value = kNotGiven;
  std::string why;
  bool assumed_ratio = false;  // depends on a cutting force that is assumed as thrust / kThrustPerCuttingForce
};

/// Returns a quantity of one tooth from its forces.
double CalcToothQuantity(std::string_view quantity, const ToothForces& forces, double width_mm, double bite_mm);
/// Returns true if the quantity depends on the cutting force.
bool UsesCuttingForce(std::string_view quantity);

/// Simulates a quantity of `set` under the conditions `at` and, where `at` gives none, those of the set.
Simulated SimulateQuantity(const ForceLaw& law, const MeasuredSet& set, std::string_view quantity,
                           const MeasuredConditions& at);

/// Returns the number of teeth that a force carries in the bone before any of them cuts; infinite if the law's force
/// begins at 0. `force_N`: on all teeth together.
double CountCarriedTeeth(const ForceLaw& law, double width_mm, double force_N);

}  // namespace kerf
