// Force against depth on an axis that is common to all cases of a comparison.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

/// A tick, projected onto the cut direction.
struct DepthSample {
  double depth_mm = 0;     // of the leading rim below the first bone, in the middle of the tick
  double force_N = 0;      // component of the force on the tool against the cut direction
  double magnitude_N = 0;  // of the whole force on the tool
  double thrust_N = 0;     // sum of the tooth forces
  double teeth = 0;        // number of engaged teeth
};

/// Bins of equal width, starting at depth 0.
struct DepthGrid {
  double step_mm = 0.05;
  std::size_t count = 0;
  double Centre(std::size_t bin) const { return step_mm * (static_cast<double>(bin) + 0.5); }
};

/// A value for each bin of a grid; NaN in bins that the case did not reach.
struct DepthCurve {
  std::vector<double> force_N;
  std::vector<double> magnitude_N;
  std::vector<double> thrust_N;
  std::vector<double> teeth;
  std::size_t interpolated = 0;  // bins without a tick between bins with ticks
  std::size_t reach = 0;         // number of bins up to and including the last one with a tick
};

/// Returns the samples in which the tool is deeper than ever before; the others are left out because bone that has
/// already been cut exerts no force.
std::vector<DepthSample> TakeAdvance(const std::vector<DepthSample>& samples);

/// Computes the mean of the samples in each bin. A bin without samples that lies between bins with samples is
/// interpolated linearly. Samples before depth 0 or beyond the grid are left out.
DepthCurve CalcDepthCurve(const std::vector<DepthSample>& samples, const DepthGrid& grid);

}  // namespace kerf
