// Force against depth on an axis that all cases of a comparison share.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

/// A tick, seen along the cut.
struct DepthSample {
  double depth_mm = 0;     // of the leading rim below the first bone, in the middle of the tick
  double force_N = 0;      // of the force on the tool: its component against the cut direction
  double magnitude_N = 0;  // of the whole force on the tool
  double thrust_N = 0;     // sum of the tooth forces
  double teeth = 0;        // engaged
};

/// Bins of equal width from depth 0 on.
struct DepthGrid {
  double step_mm = 0.05;
  std::size_t count = 0;
  double Centre(std::size_t bin) const { return step_mm * (static_cast<double>(bin) + 0.5); }
};

/// A value for each bin of a grid. NaN where the case didn't come.
struct DepthCurve {
  std::vector<double> force_N;
  std::vector<double> magnitude_N;
  std::vector<double> thrust_N;
  std::vector<double> teeth;
  std::size_t interpolated = 0;  // bins without a tick between bins with ticks
  std::size_t reach = 0;         // bins up to and with the last one that has a tick
};

/// Those in which the tool is deeper than ever before: what is cut already gives no force a second time.
std::vector<DepthSample> TakeAdvance(const std::vector<DepthSample>& samples);

/// Each bin the mean of the samples in it; a bin without any, between bins that have some, by linear interpolation
/// between those. Samples before depth 0 or past the grid are left out.
DepthCurve CalcDepthCurve(const std::vector<DepthSample>& samples, const DepthGrid& grid);

}  // namespace kerf
