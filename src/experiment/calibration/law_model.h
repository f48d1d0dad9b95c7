// The force laws that `kerf calibrate` can fit, as linear models of an edge term and a chip term.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "kerf/describe.h"

namespace kerf {

enum class ForceComponent { kThrust, kCutting };
enum class ForceTerm { kEdge, kChip };

/// Returns "thrust" or "cutting force".
std::string_view ToString(ForceComponent component);

/// A coefficient that is fitted. It is a parameter of the law, a key of [force] in a scene.
struct Coefficient {
  std::string key;
  ForceComponent component;
  ForceTerm term;
  double default_value;
  Range range;
};

/// A parameter in which the law is not linear.
struct FixedParameter {
  std::string key;
  double value;  // initially the default
  Range range;
  bool of_tool;  // it is a key of [tool] in a scene, not of [force]
};

/// Law whose force on one tooth is width * (edge coefficient * fraction + chip coefficient * bite) for each component.
/// The fraction is 1, or, if the law has a crossover, min(1, bite / (crossover_share * edge radius)).
struct LinearLaw {
  std::string name;
  std::vector<Coefficient> coefficients;
  std::vector<FixedParameter> fixed;

  bool Has(ForceComponent component) const;
  /// Returns true if the law has a crossover_share.
  bool HasCrossover() const;
  /// Throws kerf::Error if there is no fixed parameter of that name.
  double Get(std::string_view key) const;
  /// Sets a fixed parameter. Throws kerf::Error, with the nearest name, if the law has no such fixed parameter, and if
  /// the value is out of range.
  void Set(const std::string& key, double value);
  /// Bite at which the edge terms reach their full value, mm; 0 without a crossover.
  double CrossoverBite(double crossover_share) const;
};

/// Names of the laws that can be fitted.
const std::vector<std::string>& ListLinearLaws();
/// Returns the law with the default values of its fixed parameters. Throws kerf::Error for any other law.
LinearLaw MakeLinearLaw(const std::string& name);

/// Returns a term's force per mm of width for a coefficient of 1: 0 to 1 for the edge, the bite for the chip.
double CalcTerm(ForceTerm term, double bite_mm, double crossover_mm);

/// Evaluates kerf's own law (ForceLaw) with these coefficients and the law's fixed parameters: thrust on one tooth of
/// this width, N, in bone of the law's reference modulus. For the test that both definitions agree.
double CalcThrustOfLaw(const LinearLaw& law, const std::vector<double>& coefficients, double bite_mm, double width_mm);

}  // namespace kerf
