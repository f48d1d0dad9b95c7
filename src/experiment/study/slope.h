// Measured order at which an error falls with a knob's number.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace kerf {

/// The numbers and the errors of one path, equally many, all positive.
struct SlopePath {
  std::vector<double> numbers;
  std::vector<double> errors;
};

struct Slope {
  double slope = 0;
  /// 95 % confidence interval over other paths: percentile bootstrap over the paths (Efron and Tibshirani 1993, chapter
  /// 13), 2000 draws, deterministic. Unset with fewer than three paths.
  std::optional<std::pair<double, double>> interval;
  std::size_t paths = 0;   // number of paths with at least two different numbers
  std::size_t points = 0;  // number of points on these paths
};

/// Least squares of log error = a_path + slope * log number: each path has its own offset, all have one slope. Returns
/// nullopt if no path has two different numbers.
std::optional<Slope> FitSlope(const std::vector<SlopePath>& paths);

}  // namespace kerf
