// Made-up measurements from known parameters, for tests of calibrations.
#pragma once

#include <random>
#include <vector>

#include "experiment/calibration/calibration.h"

namespace kerf::test {

/// Parameters of the made-up bone, in the order of two_component's coefficients.
inline const std::vector<double> kTrueCoefficients{9.66, 468, 6.83, 166};
inline const std::vector<double> kMadeUpBites_mm{0.0025, 0.004, 0.006, 0.008, 0.010};

/// Returns the law's force for each mm of width.
inline double CalcTrueForce(const LinearLaw& law, const std::vector<double>& coefficients, ForceComponent component,
                            double bite_mm, double crossover_mm) {
  double force = 0;
  for (std::size_t j = 0; j < law.coefficients.size(); ++j) {
    if (law.coefficients[j].component != component) continue;
    force += coefficients[j] * CalcTerm(law.coefficients[j].term, bite_mm, crossover_mm);
  }
  return force;
}

/// Adds a row with one value of a component.
inline void AddValue(Measurements& data, ForceComponent component, double bite_mm, double width_mm, double force_N,
                     double sd_N = 0, std::optional<double> speed_mm_per_s = {}) {
  data.observations.push_back({component, bite_mm, width_mm, speed_mm_per_s, force_N, sd_N, data.rows()});
  data.group_of_row.push_back(data.rows());
  data.groups = data.rows();
}

/// Returns `repeats` values of each component at each bite, on a tooth 0.64 mm wide, each with a normal error. The SD
/// of the errors grows with the bite from `sd_N` to 3 `sd_N` if `weighted`, and is then given with each value.
inline Measurements MakeUpForces(const LinearLaw& law, const std::vector<double>& coefficients, int repeats,
                                 double sd_N, bool weighted, std::mt19937_64& random) {
  constexpr double kWidth_mm = 0.64;
  Measurements data;
  std::normal_distribution<double> normal;
  const double crossover_mm = law.HasCrossover() ? law.CrossoverBite(law.Get("crossover_share")) : 0;
  for (const ForceComponent component : {ForceComponent::kThrust, ForceComponent::kCutting}) {
    if (!law.Has(component)) continue;
    for (std::size_t i = 0; i < kMadeUpBites_mm.size() * static_cast<std::size_t>(repeats); ++i) {
      const std::size_t b = i % kMadeUpBites_mm.size();
      const double bite_mm = kMadeUpBites_mm[b];
      const double sd = weighted ? sd_N * (1 + 0.5 * static_cast<double>(b)) : sd_N;
      const double force = kWidth_mm * CalcTrueForce(law, coefficients, component, bite_mm, crossover_mm);
      AddValue(data, component, bite_mm, kWidth_mm, force + sd * normal(random), weighted ? sd : 0);
    }
  }
  return data;
}

}  // namespace kerf::test
