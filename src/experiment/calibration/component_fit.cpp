#include "experiment/calibration/component_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace kerf {

std::vector<ComponentData> SelectComponents(const LinearLaw& law, const Measurements& data) {
  std::vector<ComponentData> components;
  for (const ForceComponent component : {ForceComponent::kThrust, ForceComponent::kCutting}) {
    if (!law.Has(component)) continue;
    ComponentData& c = components.emplace_back();
    c.component = component;
    for (std::size_t j = 0; j < law.coefficients.size(); ++j) {
      if (law.coefficients[j].component == component) c.coefficients.push_back(j);
    }
    for (const ForceObservation& o : data.observations) {
      if (o.component == component) c.values.push_back(&o);
    }
  }
  return components;
}

LinearProblem MakeProblem(const LinearLaw& law, const ComponentData& data, double crossover_mm,
                          const std::vector<double>& counts) {
  LinearProblem problem;
  problem.columns = data.coefficients.size();
  for (const ForceObservation* o : data.values) {
    const double count = counts.empty() ? 1 : counts[o->row];
    if (count == 0) continue;
    for (const std::size_t j : data.coefficients) {
      problem.design.push_back(o->width_mm * CalcTerm(law.coefficients[j].term, o->bite_mm, crossover_mm));
    }
    problem.values.push_back(o->force_N);
    problem.weights.push_back(o->sd_N > 0 ? count / (o->sd_N * o->sd_N) : count);
  }
  return problem;
}

std::optional<CrossoverScan> FindCrossoverScan(const LinearLaw& law, const std::vector<ComponentData>& components) {
  std::set<double> bites;
  for (const ComponentData& component : components) {
    for (const ForceObservation* o : component.values) bites.insert(o->bite_mm);
  }
  if (!law.HasCrossover() || bites.size() < 3) return std::nullopt;
  if (*bites.begin() >= law.CrossoverBite(law.Get("crossover_share"))) return std::nullopt;
  return CrossoverScan{*bites.begin(), *std::next(bites.rbegin())};
}

std::optional<double> ScanCrossover(const LinearLaw& law, const std::vector<ComponentData>& components,
                                    const CrossoverScan& scan, const std::vector<double>& counts) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const auto objective = [&](double crossover_mm) {
    double sum = 0;
    for (const ComponentData& component : components) {
      if (component.values.empty()) continue;
      const NonNegativeFit fit = FitNonNegative(MakeProblem(law, component, crossover_mm, counts));
      if (!fit.fit.determined) return kNone;
      sum += static_cast<double>(component.values.size()) * std::log(std::max(fit.fit.chi2, 1e-300));
    }
    return sum;
  };
  constexpr int kGrid = 40;
  const double ratio = std::pow(scan.upper_mm / scan.lower_mm, 1.0 / kGrid);
  int best = -1;
  double least = kNone;
  for (int i = 0; i <= kGrid; ++i) {
    const double value = objective(scan.lower_mm * std::pow(ratio, i));
    if (value < least) {
      least = value;
      best = i;
    }
  }
  if (best < 0) return std::nullopt;
  double a = std::max(scan.lower_mm, scan.lower_mm * std::pow(ratio, best - 1));
  double b = std::min(scan.upper_mm, scan.lower_mm * std::pow(ratio, best + 1));
  constexpr double kGolden = std::numbers::phi - 1;
  double c = b - kGolden * (b - a);
  double d = a + kGolden * (b - a);
  double at_c = objective(c);
  double at_d = objective(d);
  while (b - a > 1e-14 * b && c < d) {
    if (at_c < at_d) {
      b = d, d = c, at_d = at_c;
      c = b - kGolden * (b - a);
      at_c = objective(c);
    } else {
      a = c, c = d, at_c = at_d;
      d = a + kGolden * (b - a);
      at_d = objective(d);
    }
  }
  const double middle = 0.5 * (a + b);
  return objective(middle) <= least ? middle : scan.lower_mm * std::pow(ratio, best);
}

}  // namespace kerf
