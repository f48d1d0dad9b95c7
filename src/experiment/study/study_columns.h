// The numeric columns of cases.csv, for writing and reading.
#pragma once

#include <array>
#include <optional>

#include "experiment/study/records.h"

namespace kerf {

/// `jnd_name` is the name of an additional column in just-noticeable differences, or null if there is none; `per_jnd`
/// is the size of one such difference.
struct ErrorColumn {
  const char* name;
  double ErrorFigures::*value;
  const char* meaning;
  const char* jnd_name = nullptr;
  double per_jnd = 1;
};
inline constexpr const char* kForceMeaning =
    "F - R against R, over the path: root mean square divided by that of R; maximum of |F - R|; 95th percentile and "
    "maximum of |F - R| / max(|R|, 0.5 N)";
inline constexpr const char* kDirectionMeaning =
    "angle between F and R, where |R| exceeds 0.5 N: 95th percentile, maximum";
inline constexpr const char* kSurfaceMeaning = "distance between the cut surfaces: mean, 95th percentile, maximum";
inline constexpr std::array<ErrorColumn, 12> kErrorColumns{{
    {"force_l2", &ErrorFigures::force_l2, kForceMeaning, "force_l2_jnd", kForceJnd},
    {"force_worst_N", &ErrorFigures::force_worst_N, kForceMeaning},
    {"force_p95", &ErrorFigures::force_p95, kForceMeaning, "force_p95_jnd", kForceJnd},
    {"force_worst", &ErrorFigures::force_worst, kForceMeaning, "force_worst_jnd", kForceJnd},
    {"direction_p95_deg", &ErrorFigures::direction_p95_deg, kDirectionMeaning, "direction_p95_jnd", kDirectionJnd_deg},
    {"direction_worst_deg", &ErrorFigures::direction_worst_deg, kDirectionMeaning, "direction_worst_jnd",
     kDirectionJnd_deg},
    {"impulse", &ErrorFigures::impulse, "magnitude of the integral of F - R, divided by the integral of |R|"},
    {"noise_N", &ErrorFigures::noise_N, "root mean square of F - R above 20 Hz"},
    {"volume", &ErrorFigures::volume, "difference of the removed volumes, as a fraction of the reference's"},
    {"surface_mean_mm", &ErrorFigures::surface_mean_mm, kSurfaceMeaning},
    {"surface_p95_mm", &ErrorFigures::surface_p95_mm, kSurfaceMeaning},
    {"surface_max_mm", &ErrorFigures::surface_max_mm, kSurfaceMeaning},
}};

/// The column of a figure that some cases lack.
struct OptionalErrorColumn {
  const char* name;
  std::optional<double> ErrorFigures::*value;
  const char* meaning;
};
inline constexpr const char* kImpulseSigned = "impulse_signed";  // not in cases.csv of earlier versions
inline constexpr const char* kTemperatureMeaning =
    "only with a heat grid: error of the temperature near the kerf, and the part of it that the reference may cause";
inline constexpr std::array<OptionalErrorColumn, 4> kOptionalErrorColumns{{
    {"breakthrough_ms", &ErrorFigures::breakthrough_ms, "delay of the breakthrough; empty if there is none"},
    {"temperature_K", &ErrorFigures::temperature_K, kTemperatureMeaning},
    {"temperature_bar_K", &ErrorFigures::temperature_bar_K, kTemperatureMeaning},
    {kImpulseSigned, &ErrorFigures::impulse_signed,
     "integral of |F| minus that of |R|, divided by that of |R|: positive if the force is too large"},
}};

struct CostColumn {
  const char* name;
  double CostFigures::*value;
  const char* meaning;
};
inline constexpr std::array<CostColumn, 4> kCostColumns{{
    {"misses_per_million", &CostFigures::misses_per_million, "ticks that take longer than their period"},
    {"memory_MB", &CostFigures::memory_MB, "memory of bone and simulation"},
    {"setup_s", &CostFigures::setup_s, "time to make both"},
    {"whole_s", &CostFigures::whole_s, "time of the fastest pass along the path, without making them"},
}};

/// Percentiles as separate columns, named `prefix` + "count", "p50_us", ...
struct PercentilesColumns {
  const char* prefix;
  Percentiles CostFigures::*value;
  const char* meaning;
};
inline constexpr std::array<PercentilesColumns, 2> kPercentilesColumns{
    {{"tick_", &CostFigures::tick, "number and times of all ticks; the percentiles may be too high by up to 3.2 %"},
     {"undisturbed_", &CostFigures::undisturbed, "the same of the ticks that the system did not interrupt"}}};
struct PercentileColumn {
  const char* name;
  double Percentiles::*value;
};
inline constexpr std::array<PercentileColumn, 4> kPercentileColumns{{{"p50_us", &Percentiles::p50_us},
                                                                     {"p99_us", &Percentiles::p99_us},
                                                                     {"p999_us", &Percentiles::p999_us},
                                                                     {"max_us", &Percentiles::max_us}}};

}  // namespace kerf
