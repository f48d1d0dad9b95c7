#include "experiment/compare/difference.h"

#include <cmath>

namespace kerf {

Difference CalcDifference(const std::vector<double>& curve_N, const std::vector<double>& reference_N,
                          const std::vector<std::size_t>& bins, double step_mm) {
  Difference d;
  double squares = 0;
  for (const std::size_t i : bins) {
    const double difference = curve_N.at(i) - reference_N.at(i);
    if (!std::isfinite(difference)) continue;
    ++d.bins;
    d.mean_N += curve_N[i];
    d.reference_mean_N += reference_N[i];
    squares += difference * difference;
    if (std::abs(difference) > std::abs(d.peak_N)) {
      d.peak_N = difference;
      d.peak_depth_mm = step_mm * (static_cast<double>(i) + 0.5);
    }
  }
  if (d.bins == 0) return d;
  const auto n = static_cast<double>(d.bins);
  d.mean_N /= n;
  d.reference_mean_N /= n;
  d.rms_N = std::sqrt(squares / n);
  return d;
}

}  // namespace kerf
