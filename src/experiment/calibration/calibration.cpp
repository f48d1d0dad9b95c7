#include "experiment/calibration/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <random>

#include "experiment/calibration/component_fit.h"
#include "experiment/calibration/least_squares.h"
#include "kerf/error.h"

namespace kerf {
namespace {

/// A fit of all components.
struct LawFit {
  double crossover_mm = 0;
  bool crossover_fitted = false;
  std::vector<NonNegativeFit> fits;  // for each component; not determined if it has no values
};

class Calibrator {
 public:
  Calibrator(const LinearLaw& law, const Measurements& data, const CalibrationParams& params, const std::string& file) {
    result_.file = file;
    result_.law = law;
    result_.data = data;
    result_.params = params;
    // components_ refers to the copy of the data in result_.
    components_ = SelectComponents(result_.law, result_.data);
    if (!params.keep_crossover) scan_ = FindCrossoverScan(result_.law, components_);
  }

  Calibration Run(const std::function<void(double)>& progress) {
    CheckUsable();
    main_ = FitAll({});
    if (std::none_of(main_.fits.begin(), main_.fits.end(), [](const auto& fit) { return fit.fit.determined; })) {
      FailUndetermined();
    }
    SetParameters();
    for (std::size_t k = 0; k < components_.size(); ++k) AddComponent(k);
    CheckSceneAccepts(result_);
    SetCovariance();
    SetIntervals();
    SetBootstrap(progress);
    result_.warnings = ListWarnings(result_);
    return std::move(result_);
  }

 private:
  void CheckUsable() const {
    if (std::any_of(components_.begin(), components_.end(), [](const ComponentData& c) { return !c.values.empty(); })) {
      return;
    }
    throw Error(fmt::format("{}: the data have no thrust, and {} has no cutting force; use the law two_component",
                            result_.file, result_.law.name));
  }

  [[noreturn]] void FailUndetermined() const {
    std::vector<double> bites;
    for (const ComponentData& c : components_) {
      for (const ForceObservation* o : c.values) bites.push_back(o->bite_mm);
    }
    const auto [low, high] = std::minmax_element(bites.begin(), bites.end());
    const std::string reason =
        *low == *high ? fmt::format("all bites are {:g} mm", *low)
        : *high <= main_.crossover_mm
            ? fmt::format("all bites are at or below the crossover of {:g} mm", main_.crossover_mm)
            : "no component has values at two different bites above the crossover";
    throw Error(fmt::format("{}: the data determine no coefficient of {}: {}", result_.file, result_.law.name, reason));
  }

  LawFit FitAll(const std::vector<double>& counts) const {
    LawFit fit;
    if (result_.law.HasCrossover()) fit.crossover_mm = result_.law.CrossoverBite(result_.law.Get("crossover_share"));
    if (scan_) {
      const auto scanned = ScanCrossover(result_.law, components_, *scan_, counts);
      fit.crossover_fitted = scanned.has_value();
      if (scanned) fit.crossover_mm = *scanned;
    }
    for (const ComponentData& component : components_) {
      fit.fits.push_back(FitNonNegative(MakeProblem(result_.law, component, fit.crossover_mm, counts)));
    }
    return fit;
  }

  bool IsAtEndOfScan() const { return main_.crossover_mm <= scan_->lower_mm * (1 + 1e-6); }

  void SetParameters() {
    const LinearLaw& law = result_.law;
    for (const Coefficient& c : law.coefficients) {
      ParameterResult& p = result_.parameters.emplace_back();
      p.key = c.key;
      p.value = c.default_value;
      p.state = ParameterState::kUndetermined;
    }
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const NonNegativeFit& fit = main_.fits[k];
      for (std::size_t j = 0; fit.fit.determined && j < components_[k].coefficients.size(); ++j) {
        ParameterResult& p = result_.parameters[components_[k].coefficients[j]];
        p.value = fit.fit.coefficients[j];
        p.unconstrained = fit.unconstrained.coefficients[j];
        p.state = fit.IsAtZero(j) ? ParameterState::kAtZero : ParameterState::kFitted;
      }
    }
    for (FixedParameter& fixed : result_.law.fixed) {
      ParameterResult& p = result_.parameters.emplace_back();
      p.key = fixed.key;
      if (fixed.key == "crossover_share" && main_.crossover_fitted) {
        fixed.value = 1e3 * main_.crossover_mm / law.Get("edge_radius_um");
        p.state = IsAtEndOfScan() ? ParameterState::kUndetermined : ParameterState::kFitted;
      }
      p.value = fixed.value;
    }
  }

  std::size_t CountFree(std::size_t k) const {
    return components_[k].coefficients.size() - static_cast<std::size_t>(std::popcount(main_.fits[k].zero_set));
  }

  void AddComponent(std::size_t k) {
    const ComponentData& data = components_[k];
    const LinearFit& fit = main_.fits[k].fit;
    ComponentResult& r = result_.components.emplace_back();
    r.component = data.component;
    r.values = data.values.size();
    r.determined = fit.determined;
    if (!fit.determined) return;
    // A fitted crossover counts as a parameter of each component that it affects.
    r.dof = static_cast<int>(r.values) - static_cast<int>(CountFree(k)) - (main_.crossover_fitted ? 1 : 0);
    r.weighted = data.values.front()->sd_N > 0;
    r.chi2 = fit.chi2;
    const LinearProblem problem = MakeProblem(result_.law, data, main_.crossover_mm);
    double sum = 0;
    double sum_of_weights = 0;
    double total = 0;
    for (std::size_t i = 0; i < problem.rows(); ++i) {
      sum += problem.weights[i] * problem.values[i];
      sum_of_weights += problem.weights[i];
      total += problem.weights[i] * problem.values[i] * problem.values[i];
    }
    double about_mean = 0;
    double residuals = 0;
    for (std::size_t i = 0; i < problem.rows(); ++i) {
      const double from_mean = problem.values[i] - sum / sum_of_weights;
      about_mean += problem.weights[i] * from_mean * from_mean;
      double residual = problem.values[i];
      for (std::size_t j = 0; j < problem.columns; ++j) {
        residual -= problem.design[i * problem.columns + j] * fit.coefficients[j];
      }
      residuals += residual * residual;
    }
    if (about_mean > 1e-24 * total) r.r2 = 1 - fit.chi2 / about_mean;
    if (r.dof <= 0) return;
    r.residual_sd_N = std::sqrt(residuals / r.dof);
    if (r.weighted) {
      r.chi2_p_value = boost::math::cdf(boost::math::complement(boost::math::chi_squared(r.dof), fit.chi2));
    }
    r.speed = TestSpeed(k, problem, r.dof);
  }

  std::optional<SpeedTest> TestSpeed(std::size_t k, const LinearProblem& problem, int dof) const {
    const ComponentData& data = components_[k];
    if (!data.values.front()->speed_mm_per_s || dof < 2) return std::nullopt;
    double mean = 0;
    for (const ForceObservation* o : data.values) mean += *o->speed_mm_per_s / static_cast<double>(data.values.size());
    LinearProblem with;
    with.values = problem.values;
    with.weights = problem.weights;
    with.columns = CountFree(k) + 1;
    double total = 0;
    for (std::size_t i = 0; i < problem.rows(); ++i) {
      for (std::size_t j = 0; j < problem.columns; ++j) {
        if (!main_.fits[k].IsAtZero(j)) with.design.push_back(problem.design[i * problem.columns + j]);
      }
      with.design.push_back(data.values[i]->width_mm * (*data.values[i]->speed_mm_per_s - mean));
      total += problem.weights[i] * problem.values[i] * problem.values[i];
    }
    const LinearFit fit = FitLeastSquares(with);
    if (!fit.determined) return std::nullopt;
    SpeedTest test{fit.coefficients.back(), 1};
    // Residuals that are only rounding errors depend on nothing.
    if (fit.chi2 <= 1e-24 * total) return test;
    const double t = fit.coefficients.back() / std::sqrt(fit.covariance.back() * fit.chi2 / (dof - 1));
    test.p_value = 2 * boost::math::cdf(boost::math::complement(boost::math::students_t(dof - 1), std::abs(t)));
    return test;
  }

  bool IsShare(std::size_t parameter) const { return parameter >= result_.law.coefficients.size(); }

  /// Adds the rows of a component to the problem whose covariance is that of all parameters together.
  void AddRows(std::size_t k, LinearProblem& joint) const {
    const ComponentData& data = components_[k];
    const LinearProblem problem = MakeProblem(result_.law, data, main_.crossover_mm);
    double total = 0;
    for (std::size_t i = 0; i < problem.rows(); ++i)
      total += problem.weights[i] * problem.values[i] * problem.values[i];
    const ComponentResult& r = result_.components[k];
    // The limit keeps weights finite if the residuals are only rounding errors.
    const double variance = std::max({r.chi2 / r.dof, 1e-32 * total, 1e-100});
    for (std::size_t i = 0; i < problem.rows(); ++i) {
      double edge = 0;
      for (const std::size_t parameter : result_.covariant) {
        const auto found = std::find(data.coefficients.begin(), data.coefficients.end(), parameter);
        if (IsShare(parameter)) {
          joint.design.push_back(edge);
        } else if (found == data.coefficients.end()) {
          joint.design.push_back(0);
        } else {
          const auto j = static_cast<std::size_t>(found - data.coefficients.begin());
          joint.design.push_back(problem.design[i * problem.columns + j]);
          // Derivative of the edge's force by crossover_share, to which it is inversely proportional below the
          // crossover.
          if (result_.law.coefficients[parameter].term == ForceTerm::kEdge &&
              data.values[i]->bite_mm < main_.crossover_mm) {
            edge = -joint.design.back() * result_.parameters[parameter].value / result_.law.Get("crossover_share");
          }
        }
      }
      joint.values.push_back(problem.values[i]);
      joint.weights.push_back(problem.weights[i] / variance);
    }
  }

  void SetCovariance() {
    for (std::size_t p = 0; p < result_.parameters.size(); ++p) {
      const ParameterResult& parameter = result_.parameters[p];
      if (parameter.state != ParameterState::kFitted) continue;
      if (!IsShare(p) && result_.Find(result_.law.coefficients[p].component).dof <= 0) continue;
      result_.covariant.push_back(p);
    }
    for (int attempt = 0; attempt < 2; ++attempt) {
      LinearProblem joint;
      joint.columns = result_.covariant.size();
      for (std::size_t k = 0; k < components_.size(); ++k) {
        if (result_.components[k].determined && result_.components[k].dof > 0) AddRows(k, joint);
      }
      const LinearFit fit = FitLeastSquares(joint);
      if (fit.determined) {
        result_.covariance = fit.covariance;
        return;
      }
      if (result_.covariant.empty() || !IsShare(result_.covariant.back())) break;
      // Without crossover_share, the others have a covariance.
      result_.parameters[result_.covariant.back()].state = ParameterState::kUndetermined;
      result_.covariant.pop_back();
    }
    result_.covariant.clear();
  }

  void SetIntervals() {
    for (std::size_t a = 0; a < result_.covariant.size(); ++a) {
      const std::size_t p = result_.covariant[a];
      ParameterResult& parameter = result_.parameters[p];
      const double error = std::sqrt(result_.covariance[a * result_.covariant.size() + a]);
      const double half = CalcTQuantile(DofOf(p)) * error;
      parameter.standard_error = error;
      parameter.interval = Interval{parameter.value - half, parameter.value + half};
    }
    for (std::size_t k = 0; k < components_.size(); ++k) {
      const NonNegativeFit& fit = main_.fits[k];
      const std::size_t columns = components_[k].coefficients.size();
      const int dof =
          static_cast<int>(components_[k].values.size()) - static_cast<int>(columns) - (main_.crossover_fitted ? 1 : 0);
      for (std::size_t j = 0; fit.fit.determined && dof > 0 && j < columns; ++j) {
        if (!fit.IsAtZero(j)) continue;
        const double error = std::sqrt(fit.unconstrained.covariance[j * columns + j] * fit.unconstrained.chi2 / dof);
        const double upper = fit.unconstrained.coefficients[j] + CalcTQuantile(dof) * error;
        result_.parameters[components_[k].coefficients[j]].interval = Interval{0, std::max(0.0, upper)};
      }
    }
  }

  /// Returns the degrees of freedom of a parameter: of its component, or of all for crossover_share.
  int DofOf(std::size_t parameter) const {
    if (parameter < result_.law.coefficients.size()) {
      return result_.Find(result_.law.coefficients[parameter].component).dof;
    }
    int dof = 0;
    for (const ComponentResult& r : result_.components) dof += r.determined ? std::max(r.dof, 0) : 0;
    return dof;
  }

  void SetBootstrap(const std::function<void(double)>& progress) {
    std::vector<std::vector<double>> draws(result_.parameters.size());
    std::mt19937_64 random(result_.params.seed);
    for (int i = 0; i < result_.params.bootstrap; ++i) {
      if (progress) progress(static_cast<double>(i) / result_.params.bootstrap);
      std::vector<double> of_group(result_.data.groups);
      for (std::size_t g = 0; g < result_.data.groups; ++g) ++of_group[random() % result_.data.groups];
      std::vector<double> counts;
      for (const std::size_t group : result_.data.group_of_row) counts.push_back(of_group[group]);
      const LawFit fit = FitAll(counts);
      if (!IsComparable(fit)) continue;
      ++result_.resamples_used;
      for (std::size_t k = 0; k < components_.size(); ++k) {
        for (std::size_t j = 0; main_.fits[k].fit.determined && j < components_[k].coefficients.size(); ++j) {
          draws[components_[k].coefficients[j]].push_back(fit.fits[k].fit.coefficients[j]);
        }
      }
      for (std::size_t p = result_.law.coefficients.size(); p < result_.parameters.size(); ++p) {
        if (result_.parameters[p].state != ParameterState::kFitted) continue;
        draws[p].push_back(1e3 * fit.crossover_mm / result_.law.Get("edge_radius_um"));
      }
    }
    for (std::size_t p = 0; p < draws.size(); ++p) {
      if (draws[p].size() < std::size_t{kMinResamples}) continue;
      std::sort(draws[p].begin(), draws[p].end());
      result_.parameters[p].bootstrap = Interval{CalcQuantile(draws[p], 0.025), CalcQuantile(draws[p], 0.975)};
    }
  }

  /// Returns true if a resample determines all that the data do.
  bool IsComparable(const LawFit& fit) const {
    for (std::size_t k = 0; k < components_.size(); ++k) {
      if (main_.fits[k].fit.determined && !fit.fits[k].fit.determined) return false;
    }
    return fit.crossover_fitted == main_.crossover_fitted;
  }

  static double CalcQuantile(const std::vector<double>& sorted, double fraction) {
    const double at = fraction * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(at);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return std::lerp(sorted[below], sorted[above], at - static_cast<double>(below));
  }

  Calibration result_;
  std::vector<ComponentData> components_;
  std::optional<CrossoverScan> scan_;
  LawFit main_;
};

}  // namespace

std::string_view ToString(ParameterState state) {
  switch (state) {
    case ParameterState::kFitted:
      return "fitted";
    case ParameterState::kAtZero:
      return "at 0";
    case ParameterState::kKept:
      return "kept";
    case ParameterState::kUndetermined:
      break;
  }
  return "not determined";
}

double CalcTQuantile(int dof) {
  return boost::math::quantile(boost::math::students_t(dof), 0.975);
}

const ComponentResult& Calibration::Find(ForceComponent component) const {
  const auto found = std::find_if(components.begin(), components.end(),
                                  [&](const ComponentResult& r) { return r.component == component; });
  if (found == components.end()) throw Error(fmt::format("{} has no {}", law.name, ToString(component)));
  return *found;
}

double Calibration::CorrelationOf(std::size_t a, std::size_t b) const {
  const std::size_t n = covariant.size();
  return covariance[a * n + b] / std::sqrt(covariance[a * n + a] * covariance[b * n + b]);
}

double Calibration::CrossoverBite_mm() const {
  return law.HasCrossover() ? law.CrossoverBite(law.Get("crossover_share")) : 0;
}

double Calibration::CalcForcePerWidth(ForceComponent component, double bite_mm) const {
  double force_N_per_mm = 0;
  for (std::size_t j = 0; j < law.coefficients.size(); ++j) {
    if (law.coefficients[j].component != component) continue;
    force_N_per_mm += parameters[j].value * CalcTerm(law.coefficients[j].term, bite_mm, CrossoverBite_mm());
  }
  return force_N_per_mm;
}

std::optional<double> Calibration::CalcHalfBand(ForceComponent component, double bite_mm) const {
  const ComponentResult& r = Find(component);
  if (!r.determined || r.dof <= 0) return std::nullopt;
  const std::size_t n = covariant.size();
  std::vector<double> gradient(n);
  double edge_N_per_mm = 0;
  for (std::size_t a = 0; a < n; ++a) {
    if (covariant[a] >= law.coefficients.size()) {
      if (bite_mm < CrossoverBite_mm()) gradient[a] = -edge_N_per_mm / law.Get("crossover_share");
      continue;
    }
    const Coefficient& c = law.coefficients[covariant[a]];
    if (c.component != component) continue;
    gradient[a] = CalcTerm(c.term, bite_mm, CrossoverBite_mm());
    if (c.term == ForceTerm::kEdge) edge_N_per_mm = gradient[a] * parameters[covariant[a]].value;
  }
  double variance = 0;
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b < n; ++b) variance += gradient[a] * covariance[a * n + b] * gradient[b];
  }
  return CalcTQuantile(r.dof) * std::sqrt(std::max(variance, 0.0));
}

Calibration CalibrateLaw(const LinearLaw& law, const Measurements& data, const CalibrationParams& params,
                         const std::string& file, const std::function<void(double)>& progress) {
  CheckParameters(params);
  return Calibrator(law, data, params, file).Run(progress);
}

}  // namespace kerf
