// What the data of a calibration do not determine.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/core/number_text.h"
#include "experiment/calibration/calibration.h"
#include "kerf/error.h"

namespace kerf {
namespace {

std::set<double> BitesOf(const Calibration& c, ForceComponent component) {
  std::set<double> bites;
  for (const ForceObservation& o : c.data.observations) {
    if (o.component == component) bites.insert(o.bite_mm);
  }
  return bites;
}

std::string KeysOf(const Calibration& c, ForceComponent component) {
  std::vector<std::string> keys;
  for (const Coefficient& k : c.law.coefficients) {
    if (k.component == component) keys.push_back(k.key);
  }
  return fmt::format("{}", fmt::join(keys, " and "));
}

void WarnOfComponents(const Calibration& c, std::vector<std::string>& warnings) {
  for (const ForceComponent component : {ForceComponent::kThrust, ForceComponent::kCutting}) {
    const std::set<double> bites = BitesOf(c, component);
    if (!c.law.Has(component)) {
      if (bites.empty()) continue;
      warnings.push_back(
          fmt::format("{} has no {}; its values in the data are not used", c.law.name, ToString(component)));
      continue;
    }
    const ComponentResult& r = c.Find(component);
    const std::string lost = fmt::format("{} are not determined", KeysOf(c, component));
    if (bites.empty()) {
      warnings.push_back(fmt::format("the data have no {}: {}", ToString(component), lost));
    } else if (bites.size() == 1) {
      warnings.push_back(
          fmt::format("all values of the {} have the bite {:g} mm, so edge and chip can't be separated: {}",
                      ToString(component), *bites.begin(), lost));
    } else if (!r.determined) {
      warnings.push_back(fmt::format(
          "the {} has no two different bites above the crossover of {:g} mm, so edge and chip can't be separated: {}",
          ToString(component), c.CrossoverBite_mm(), lost));
    } else if (r.dof <= 0) {
      warnings.push_back(
          fmt::format("the {} has no more values than parameters: there are no standard errors and no intervals",
                      ToString(component)));
    }
  }
}

void WarnOfParameters(const Calibration& c, std::vector<std::string>& warnings) {
  for (const ParameterResult& p : c.parameters) {
    if (p.state == ParameterState::kAtZero) {
      warnings.push_back(fmt::format(
          "{} would be {} without limits; it is set to 0, the lowest value that a scene accepts, and the others were "
          "fitted again",
          p.key, ShowThree(p.unconstrained)));
    } else if (p.state == ParameterState::kFitted && p.value > 0 && p.interval &&
               p.interval->upper - p.interval->lower > p.value) {
      warnings.push_back(
          fmt::format("{} is poorly determined: its 95 % interval, {} to {}, is wider than its estimate, {}", p.key,
                      ShowThree(p.interval->lower), ShowThree(p.interval->upper), ShowThree(p.value)));
    }
  }
}

/// Returns a question if the fitted force has the size of a usual one in another unit than N; otherwise "".
std::string AskForUnit(const Calibration& c) {
  struct Unit {
    const char* name;
    double per_N;
  };
  constexpr Unit kUnits[] = {{"mN", 1000}, {"gf", 102}, {"kgf", 0.102}, {"kN", 0.001}};
  constexpr double kSpread = 3;  // by which studies differ
  for (const ComponentResult& r : c.components) {
    if (!r.determined) continue;
    const std::set<double> bites = BitesOf(c, r.component);
    const double bite_mm = std::sqrt(*bites.begin() * *bites.rbegin());
    double usual = 0;
    for (const Coefficient& k : c.law.coefficients) {
      if (k.component == r.component) usual += k.default_value * CalcTerm(k.term, bite_mm, c.CrossoverBite_mm());
    }
    const double ratio = c.CalcForcePerWidth(r.component, bite_mm) / usual;
    for (const Unit& unit : kUnits) {
      if (ratio < unit.per_N / kSpread || ratio > unit.per_N * kSpread) continue;
      return fmt::format(
          "the {} is {} times that of cortical bone by the law's defaults: was it measured in {} instead of N?",
          ToString(r.component), ShowThree(ratio), unit.name);
    }
  }
  return "";
}

void WarnOfBites(const Calibration& c, std::vector<std::string>& warnings) {
  std::set<double> bites = BitesOf(c, ForceComponent::kThrust);
  bites.merge(BitesOf(c, ForceComponent::kCutting));
  const bool outside =
      std::none_of(bites.begin(), bites.end(), [](double b) { return kPublishedBites_mm.Contains(b); });
  if (outside) {
    warnings.push_back(fmt::format(
        "all bites are outside {:g} to {:g} mm, where the forces of saw teeth were published: the result can't be "
        "compared with them, and within that range it is an extrapolation",
        kPublishedBites_mm.lower, kPublishedBites_mm.upper));
  }
  if (!c.law.HasCrossover()) return;
  const auto share = std::find_if(c.parameters.begin(), c.parameters.end(),
                                  [](const ParameterResult& p) { return p.key == "crossover_share"; });
  const double crossover_mm = c.CrossoverBite_mm();
  const auto below = std::count_if(bites.begin(), bites.end(), [&](double b) { return b < crossover_mm; });
  if (share->state == ParameterState::kUndetermined) {
    warnings.push_back(
        fmt::format("crossover_share is not determined: the data show no crossover, so it is set to {}, where the "
                    "crossover is at the "
                    "smallest bite or the fit is not sensitive to it",
                    ShowThree(share->value)));
  } else if (share->state == ParameterState::kKept && below == 0) {
    warnings.push_back(fmt::format(
        "crossover_share is not determined: no bite is below the crossover of {:g} mm; {} is kept, an assumption",
        crossover_mm, ShowThree(share->value)));
  } else if (share->state == ParameterState::kKept && !c.params.keep_crossover) {
    warnings.push_back(fmt::format(
        "crossover_share is not determined: the data have fewer than three different bites; {} is kept, an assumption",
        ShowThree(share->value)));
  }
}

void WarnOfResiduals(const Calibration& c, std::vector<std::string>& warnings) {
  for (const ComponentResult& r : c.components) {
    constexpr double kSignificant = 0.05;
    if (r.speed && r.speed->p_value < kSignificant) {
      warnings.push_back(
          fmt::format("the residuals of the {} depend on the cutting speed (p = {:.2g}): {:+.3g} N for each mm of "
                      "width and m/s; the "
                      "law has no such term",
                      ToString(r.component), r.speed->p_value, 1000 * r.speed->slope_Ns_per_mm2));
    }
    constexpr double kUnlikely = 0.01;
    if (r.chi2_p_value && *r.chi2_p_value < kUnlikely) {
      warnings.push_back(fmt::format(
          "the residuals of the {} are larger than the SDs explain (chi2 / dof = {:.3g}): the law does not fit, or the "
          "SDs are too small{}",
          ToString(r.component), r.chi2 / r.dof,
          c.data.specimens > 1 ? " or do not include the differences between specimens" : ""));
    } else if (r.chi2_p_value && *r.chi2_p_value > 1 - kUnlikely) {
      warnings.push_back(
          fmt::format("the residuals of the {} are smaller than the SDs explain (chi2 / dof = {:.3g}): the intervals "
                      "are too narrow "
                      "if the SDs are right",
                      ToString(r.component), r.chi2 / r.dof));
    }
  }
}

void WarnOfSpecimens(const Calibration& c, std::vector<std::string>& warnings) {
  if (c.data.specimens == 1) {
    warnings.emplace_back(
        "all values are from one specimen: the intervals do not include the variation between specimens");
  } else if (c.data.specimens > 1 && c.data.specimens < c.data.rows()) {
    warnings.push_back(
        fmt::format("standard errors and intervals by the t distribution treat the {} rows as independent, although "
                    "they are from {} "
                    "specimens; the bootstrap resamples specimens",
                    c.data.rows(), c.data.specimens));
  }
  constexpr std::size_t kFewGroups = 10;
  if (c.params.bootstrap > 0 && c.data.groups < kFewGroups) {
    warnings.push_back(fmt::format("the bootstrap resamples only {} {}: its intervals are too narrow", c.data.groups,
                                   c.data.specimens > 1 ? "specimens" : "rows"));
  }
  if (c.resamples_used < c.params.bootstrap) {
    warnings.push_back(
        fmt::format("{} of {} resamples of the bootstrap do not determine the parameters and are left out",
                    c.params.bootstrap - c.resamples_used, c.params.bootstrap));
  }
}

}  // namespace

void CheckSceneAccepts(const Calibration& c) {
  const std::size_t coefficients = c.law.coefficients.size();
  for (std::size_t j = 0; j < c.parameters.size(); ++j) {
    const ParameterResult& p = c.parameters[j];
    const Range range = j < coefficients ? c.law.coefficients[j].range : c.law.fixed[j - coefficients].range;
    if (range.Contains(p.value)) continue;
    const std::string unit = AskForUnit(c);
    throw Error(fmt::format("{}: {} = {} is outside {:g} to {:g}, which a scene accepts: {}", c.file, p.key,
                            ShowThree(p.value), range.lower, range.upper,
                            unit.empty() ? "check the units of the data" : unit));
  }
}

std::vector<std::string> ListWarnings(const Calibration& c) {
  std::vector<std::string> warnings;
  if (const std::string unit = AskForUnit(c); !unit.empty()) warnings.push_back(unit);
  WarnOfComponents(c, warnings);
  WarnOfParameters(c, warnings);
  WarnOfBites(c, warnings);
  WarnOfResiduals(c, warnings);
  WarnOfSpecimens(c, warnings);
  return warnings;
}

}  // namespace kerf
