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
  const char* jnd_name;
  double per_jnd;
};
inline constexpr std::array<ErrorColumn, 12> kErrorColumns{{
    {"force_l2", &ErrorFigures::force_l2, "force_l2_jnd", kForceJnd},
    {"force_worst_N", &ErrorFigures::force_worst_N, nullptr, 0},
    {"force_p95", &ErrorFigures::force_p95, "force_p95_jnd", kForceJnd},
    {"force_worst", &ErrorFigures::force_worst, "force_worst_jnd", kForceJnd},
    {"direction_p95_deg", &ErrorFigures::direction_p95_deg, "direction_p95_jnd", kDirectionJnd_deg},
    {"direction_worst_deg", &ErrorFigures::direction_worst_deg, "direction_worst_jnd", kDirectionJnd_deg},
    {"impulse", &ErrorFigures::impulse, nullptr, 0},
    {"noise_N", &ErrorFigures::noise_N, nullptr, 0},
    {"volume", &ErrorFigures::volume, nullptr, 0},
    {"surface_mean_mm", &ErrorFigures::surface_mean_mm, nullptr, 0},
    {"surface_p95_mm", &ErrorFigures::surface_p95_mm, nullptr, 0},
    {"surface_max_mm", &ErrorFigures::surface_max_mm, nullptr, 0},
}};

/// The column of a figure that some cases lack.
struct OptionalErrorColumn {
  const char* name;
  std::optional<double> ErrorFigures::*value;
};
inline constexpr const char* kImpulseSigned = "impulse_signed";  // not in cases.csv of earlier versions
inline constexpr std::array<OptionalErrorColumn, 4> kOptionalErrorColumns{{
    {"breakthrough_ms", &ErrorFigures::breakthrough_ms},
    {"temperature_K", &ErrorFigures::temperature_K},
    {"temperature_bar_K", &ErrorFigures::temperature_bar_K},
    {kImpulseSigned, &ErrorFigures::impulse_signed},
}};

struct CostColumn {
  const char* name;
  double CostFigures::*value;
};
inline constexpr std::array<CostColumn, 4> kCostColumns{{
    {"misses_per_million", &CostFigures::misses_per_million},
    {"memory_MB", &CostFigures::memory_MB},
    {"setup_s", &CostFigures::setup_s},
    {"whole_s", &CostFigures::whole_s},
}};

/// Percentiles as separate columns, named `prefix` + "count", "p50_us", ...
struct PercentilesColumns {
  const char* prefix;
  Percentiles CostFigures::*value;
};
inline constexpr std::array<PercentilesColumns, 2> kPercentilesColumns{
    {{"tick_", &CostFigures::tick}, {"undisturbed_", &CostFigures::undisturbed}}};
struct PercentileColumn {
  const char* name;
  double Percentiles::*value;
};
inline constexpr std::array<PercentileColumn, 4> kPercentileColumns{{{"p50_us", &Percentiles::p50_us},
                                                                     {"p99_us", &Percentiles::p99_us},
                                                                     {"p999_us", &Percentiles::p999_us},
                                                                     {"max_us", &Percentiles::max_us}}};

}  // namespace kerf
