// What of a signal is fast.
#pragma once

#include <span>

namespace kerf {

/// Root mean square of `x`, sampled every dt_s, above cutoff_Hz: after a second-order Butterworth high-pass forwards
/// and backwards, which shifts nothing in time and halves what is at the cut-off. The ends are continued by reflection
/// in the end points, so that a straight line is nothing. 0 for fewer than 3 samples. Throws Error unless 0 < cutoff_Hz
/// < 1 / (2 dt_s).
double CalcHighPassRms(std::span<const double> x, double dt_s, double cutoff_Hz);

}  // namespace kerf
