// The order at which an error falls with a knob's number, as measured.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace kerf {

/// One path: as many errors as numbers, all positive.
struct SlopePath {
  std::vector<double> numbers;
  std::vector<double> errors;
};

struct Slope {
  double slope = 0;
  /// 95 % of what other paths would have given: percentile bootstrap over the paths (Efron and Tibshirani 1993, chapter
  /// 13), 2000 draws, always the same. None with fewer than three paths.
  std::optional<std::pair<double, double>> interval;
  std::size_t paths = 0;   // with two different numbers at least
  std::size_t points = 0;  // on them
};

/// Least squares of log error = a_path + slope * log number: each path has its own height, all have one slope. None
/// when no path has two different numbers.
std::optional<Slope> FitSlope(const std::vector<SlopePath>& paths);

}  // namespace kerf
