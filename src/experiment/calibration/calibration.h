// Calibration of a force law: its coefficients from measured forces, with their uncertainty.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "experiment/calibration/law_model.h"
#include "experiment/calibration/measurements.h"
#include "kerf/describe.h"

namespace kerf {

/// Bites between which the published forces of single saw teeth were measured (docs/physics.md).
inline constexpr Range kPublishedBites_mm{0.002, 0.010};

/// Percentiles of fewer resamples are not those of the distribution.
inline constexpr int kMinResamples = 100;

struct CalibrationParams {
  int bootstrap = 2000;
  std::uint64_t seed = 1;
  /// Keeps crossover_share at the law's value even if the data contain smaller bites.
  bool keep_crossover = false;
};
template <typename V>
void Describe(CalibrationParams& p, V&& visit) {
  visit("bootstrap", p.bootstrap, Range{kMinResamples, 100000, kOrZero},
        "number of resamples of the bootstrap; 0: no bootstrap");
  visit("seed", p.seed, Range{0, 9007199254740992}, "seed of the resampling");
}

struct Interval {
  double lower;
  double upper;
};

enum class ParameterState {
  kFitted,
  kAtZero,        // a fit without limits would be negative; 0, and the others fitted again
  kKept,          // not fitted
  kUndetermined,  // the data do not determine it; the law's default
};
/// Returns "fitted", "at 0", "kept" or "not determined".
std::string_view ToString(ParameterState state);

struct ParameterResult {
  std::string key;
  ParameterState state = ParameterState::kKept;
  double value = 0;
  double unconstrained = 0;  // of a parameter at 0: the estimate without limits
  std::optional<double> standard_error;
  /// 95 %, by the t distribution; for a parameter at 0: from 0 to the upper end for the fit without limits. May reach
  /// below 0.
  std::optional<Interval> interval;
  /// 95 %, percentiles of the bootstrap.
  std::optional<Interval> bootstrap;
};

/// Test of whether the residuals depend on the cutting speed: the change of the force for each mm of width and each
/// mm/s, fitted together with the coefficients. It is never part of the law.
struct SpeedTest {
  double slope_Ns_per_mm2 = 0;
  double p_value = 1;  // of a slope at least that large if there is none
};

/// The fit of one component.
struct ComponentResult {
  ForceComponent component;
  std::size_t values = 0;
  bool determined = false;   // if not, the rest is not set
  int dof = 0;               // degrees of freedom
  bool weighted = false;     // the data have standard deviations
  double chi2 = 0;           // sum of squared residuals, each divided by its SD if weighted
  double residual_sd_N = 0;  // root of the mean squared residual over the degrees of freedom, without weights
  std::optional<double> r2;
  std::optional<double> chi2_p_value;  // if weighted: of a chi2 at least that large if the SDs are right
  std::optional<SpeedTest> speed;      // unset: no speeds, or the data do not determine their influence
};

struct Calibration {
  std::string file;  // without its folder
  LinearLaw law;     // with the fixed parameters used
  Measurements data;
  CalibrationParams params;
  std::vector<ParameterResult> parameters;  // the coefficients in the order of the law, then the fixed parameters
  std::vector<ComponentResult> components;  // those of the law
  /// Covariance of the parameters with a standard error, by row, and their indices in `parameters`.
  std::vector<std::size_t> covariant;
  std::vector<double> covariance;
  int resamples_used = 0;  // those that determined all fitted parameters
  std::vector<std::string> warnings;

  const ComponentResult& Find(ForceComponent component) const;
  double CorrelationOf(std::size_t a, std::size_t b) const;  // of entries of `covariant`
  double CrossoverBite_mm() const;
  /// Force for each mm of width, N/mm. The component must be determined.
  double CalcForcePerWidth(ForceComponent component, double bite_mm) const;
  /// Half of the 95 % interval of that force; unset without degrees of freedom.
  std::optional<double> CalcHalfBand(ForceComponent component, double bite_mm) const;
};

/// Fits the law to the data. Throws kerf::Error if the law uses none of the data, if the data determine none of the
/// law's coefficients, and if a scene would not accept the result.
///
/// Each component is fitted by weighted least squares; its weights are 1 / SD^2 if SDs are given, otherwise equal. The
/// covariance is scaled by chi2 / degrees of freedom, so SDs need only be right relative to each other. crossover_share
/// is fitted by a scan if the data have bites below the law's crossover and it is not kept; its standard error is that
/// of the linearised model.
///
/// `progress` is called during the bootstrap with the fraction that is done.
Calibration CalibrateLaw(const LinearLaw& law, const Measurements& data, const CalibrationParams& params,
                         const std::string& file, const std::function<void(double)>& progress = {});

/// Throws kerf::Error if a parameter is outside the range of the scene's key.
void CheckSceneAccepts(const Calibration& calibration);
/// Returns a sentence for each thing that the data do not determine, or that a user of the result must know.
std::vector<std::string> ListWarnings(const Calibration& calibration);

/// Returns the half-width of a two-sided 95 % interval in standard errors: the t distribution's quantile.
double CalcTQuantile(int dof);

}  // namespace kerf
