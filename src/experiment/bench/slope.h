// The measured order of an error: the exponent of the knob's number.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace kerf {

/// A knob's numbers and the errors at these numbers on one path; all are positive.
struct SlopePath {
  std::vector<double> numbers;
  std::vector<double> errors;
};

struct Slope {
  double slope = 0;
  /// 95 % confidence interval for other paths, from a percentile bootstrap over the paths (Efron and Tibshirani 1993,
  /// chapter 13) with 2000 draws. Deterministic. Unset if there are fewer than three paths.
  std::optional<std::pair<double, double>> interval;
  std::size_t paths = 0;   // number of paths with at least two different numbers
  std::size_t points = 0;  // number of points on these paths
};

/// Fits log error = a_path + slope * log number by least squares: each path has its own offset, and all paths share one
/// slope. Returns nullopt if no path has two different numbers.
std::optional<Slope> FitSlope(const std::vector<SlopePath>& paths);

}  // namespace kerf
