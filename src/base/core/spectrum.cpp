#include "base/core/spectrum.h"

#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "kerf/error.h"

namespace kerf {
namespace {

using Complex = std::complex<double>;

/// Computes the Fourier transform in place; the size must be a power of two (Cooley and Tukey 1965).
void Transform(std::vector<Complex>& x) {
  const std::size_t n = x.size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n / 2;
    for (; (j & bit) != 0; bit /= 2) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(x[i], x[j]);
  }
  for (std::size_t length = 2; length <= n; length *= 2) {
    const std::size_t half = length / 2;
    std::vector<Complex> twiddles(half);
    for (std::size_t k = 0; k < half; ++k)
      twiddles[k] = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(length));
    for (std::size_t begin = 0; begin < n; begin += length) {
      for (std::size_t k = 0; k < half; ++k) {
        const Complex a = x[begin + k], b = twiddles[k] * x[begin + k + half];
        x[begin + k] = a + b;
        x[begin + k + half] = a - b;
      }
    }
  }
}

}  // namespace

std::vector<double> CalcAmplitudes(std::span<const double> x) {
  if (x.size() < 4 || !std::has_single_bit(x.size()))
    throw Error("the number of values for a spectrum must be a power of two, at least 4");
  const auto n = static_cast<double>(x.size());
  std::vector<Complex> bins(x.size());
  for (std::size_t i = 0; i < x.size(); ++i)
    bins[i] = x[i] * (1 - std::cos(2 * std::numbers::pi * static_cast<double>(i) / n));
  Transform(bins);
  std::vector<double> amplitudes(x.size() / 2);
  for (std::size_t k = 0; k < amplitudes.size(); ++k) amplitudes[k] = (k == 0 ? 1 : 2) * std::abs(bins[k]) / n;
  return amplitudes;
}

}  // namespace kerf
