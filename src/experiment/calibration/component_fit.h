// The fit of a law without statistics: the part that the bootstrap repeats.
#pragma once

#include <optional>
#include <vector>

#include "experiment/calibration/law_model.h"
#include "experiment/calibration/least_squares.h"
#include "experiment/calibration/measurements.h"

namespace kerf {

/// The observations of one component and the coefficients that belong to it.
struct ComponentData {
  ForceComponent component;
  std::vector<std::size_t> coefficients;  // indices in LinearLaw::coefficients
  std::vector<const ForceObservation*> values;
};

/// Returns the components of the law, with the observations of each.
std::vector<ComponentData> SelectComponents(const LinearLaw& law, const Measurements& data);

/// Returns the linear problem of a component for a crossover bite. `counts`: multiplicity of each row of the file;
/// empty: all 1.
LinearProblem MakeProblem(const LinearLaw& law, const ComponentData& data, double crossover_mm,
                          const std::vector<double>& counts = {});

/// Range of crossover bites in which the data can determine the crossover.
struct CrossoverScan {
  double lower_mm;  // the smallest bite
  double upper_mm;  // the second largest bite
};
/// Returns none if there are fewer than three different bites, or no bite is below the law's crossover.
std::optional<CrossoverScan> FindCrossoverScan(const LinearLaw& law, const std::vector<ComponentData>& components);

/// Returns the crossover bite with the smallest product of the components' chi2 ^ values (the likelihood's maximum for
/// unknown variances), within the scan: a grid, then a golden section. Returns none if a component has no solution.
std::optional<double> ScanCrossover(const LinearLaw& law, const std::vector<ComponentData>& components,
                                    const CrossoverScan& scan, const std::vector<double>& counts = {});

}  // namespace kerf
