#include "core/high_pass.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

/// Second-order section, transposed direct form II.
struct Section {
  double b0, b1, b2, a1, a2;
  void Run(std::vector<double>& x) const {
    // Begins as if x had been at its first value for ever, of which a high-pass gives 0.
    double z1 = -b0 * x.front();
    double z2 = b2 * x.front();
    for (double& value : x) {
      const double in = value;
      const double out = b0 * in + z1;
      z1 = b1 * in - a1 * out + z2;
      z2 = b2 * in - a2 * out;
      value = out;
    }
  }
};

Section MakeHighPass(double dt_s, double cutoff_Hz) {
  const double k = std::tan(std::numbers::pi * cutoff_Hz * dt_s);
  const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  return {norm, -2 * norm, norm, 2 * (k * k - 1) * norm, (1 - std::numbers::sqrt2 * k + k * k) * norm};
}

}  // namespace

double CalcHighPassRms(std::span<const double> x, double dt_s, double cutoff_Hz) {
  if (!(dt_s > 0) || !(cutoff_Hz > 0) || !(cutoff_Hz * dt_s < 0.5)) {
    throw Error(
        fmt::format("a high-pass at {} Hz of samples every {} s: the frequency is not above 0 and below half the "
                    "sampling's",
                    cutoff_Hz, dt_s));
  }
  const std::size_t n = x.size();
  if (n < 3) return 0;
  const auto settle = static_cast<std::size_t>(5 / (cutoff_Hz * dt_s)) + 1;
  const std::size_t pad = std::min(n - 1, settle);
  std::vector<double> y;
  y.reserve(n + 2 * pad);
  for (std::size_t i = pad; i > 0; --i) y.push_back(2 * x[0] - x[i]);
  y.insert(y.end(), x.begin(), x.end());
  for (std::size_t i = 1; i <= pad; ++i) y.push_back(2 * x[n - 1] - x[n - 1 - i]);

  const Section section = MakeHighPass(dt_s, cutoff_Hz);
  section.Run(y);
  std::reverse(y.begin(), y.end());
  section.Run(y);
  double sum = 0;
  for (std::size_t i = pad; i < pad + n; ++i) sum += y[i] * y[i];
  return std::sqrt(sum / static_cast<double>(n));
}

}  // namespace kerf
