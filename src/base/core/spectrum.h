// Amplitudes of a signal by frequency.
#pragma once

#include <span>
#include <vector>

namespace kerf {

/// Of the frequencies 0, 1 / T, 2 / T ... below half the sampling rate, T the time that `x` takes: a sine of amplitude
/// A at one of them gives A there, and half of it to either side (Hann's window). Throws Error unless the number of
/// values is a power of two, at least 4.
std::vector<double> CalcAmplitudes(std::span<const double> x);

}  // namespace kerf
