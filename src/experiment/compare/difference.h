// How far two curves are apart.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

/// Of one curve from a reference, over some bins. All 0 for no bins.
struct Difference {
  std::size_t bins = 0;
  double mean_N = 0;  // of the curve
  double reference_mean_N = 0;
  double rms_N = 0;          // root of the mean of the squared differences
  double peak_N = 0;         // the difference largest in magnitude, with its sign
  double peak_depth_mm = 0;  // where that is
};

/// Over the bins `bins` (indices, in order) of two curves of equal grid. Bins where either is NaN are left out.
Difference CalcDifference(const std::vector<double>& curve_N, const std::vector<double>& reference_N,
                          const std::vector<std::size_t>& bins, double step_mm);

}  // namespace kerf
