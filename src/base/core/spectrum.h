// Amplitude spectrum of a signal.
#pragma once

#include <span>
#include <vector>

namespace kerf {

/// Computes the amplitudes at the frequencies 0, 1 / T, 2 / T ... below half the sampling rate, where T is the duration
/// of `x`. A sine of amplitude A at one of these frequencies yields A there and A / 2 at both neighbours (Hann window).
/// Throws kerf::Error unless the number of values is a power of two and at least 4.
std::vector<double> CalcAmplitudes(std::span<const double> x);

}  // namespace kerf
