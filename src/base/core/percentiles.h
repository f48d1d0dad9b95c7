// Nearest-rank percentiles.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "base/core/log_histogram.h"

namespace kerf {

/// Returns the smallest of the values that at least the given fraction (0 to 1) of them do not exceed; 0 if there are
/// no values.
template <typename T>
T CalcPercentile(std::vector<T> values, double fraction) {
  if (values.empty()) return 0;
  // The product may be rounded up past a whole number.
  const double rank = std::ceil(fraction * static_cast<double>(values.size()) - 1e-9);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::max(1.0, rank)) - 1;
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Percentiles of a set of times, us; all 0 if there are no times.
struct Percentiles {
  std::size_t count = 0;
  double p50_us = 0;
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};

inline Percentiles CalcPercentiles(const std::vector<double>& times_us) {
  return {times_us.size(), CalcPercentile(times_us, 0.5), CalcPercentile(times_us, 0.99),
          CalcPercentile(times_us, 0.999), CalcPercentile(times_us, 1)};
}
/// The percentiles are at most 3.2 % above the true ones (LogHistogram).
inline Percentiles CalcPercentiles(const LogHistogram& times) {
  return {static_cast<std::size_t>(times.total()), times.CalcPercentile_us(0.5), times.CalcPercentile_us(0.99),
          times.CalcPercentile_us(0.999), times.max_us()};
}

}  // namespace kerf
