// Difference between two curves.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

/// Difference of a curve from a reference over a set of bins. All 0 if there are no bins.
struct Difference {
  std::size_t bins = 0;
  double mean_N = 0;  // of the curve
  double reference_mean_N = 0;
  double rms_N = 0;          // root of the mean of the squared differences
  double peak_N = 0;         // difference with the largest magnitude, signed
  double peak_depth_mm = 0;  // depth of that bin
};

/// Compares two curves on the same grid over the bins whose indices `bins` lists in ascending order. Bins where either
/// curve is NaN are left out.
Difference CalcDifference(const std::vector<double>& curve_N, const std::vector<double>& reference_N,
                          const std::vector<std::size_t>& bins, double step_mm);

}  // namespace kerf
