#include "experiment/stability/measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "base/core/high_pass.h"
#include "base/core/percentiles.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

bool IsFinite(std::span<const double> f) {
  return std::all_of(f.begin(), f.end(), [](double x) { return std::isfinite(x); });
}
bool IsFinite(std::span<const Vec3> f) {
  return std::all_of(f.begin(), f.end(),
                     [](const Vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); });
}

void Check(bool good, const char* what, double value) {
  if (!good) throw Error(fmt::format("a measure of a signal: {} {} is out of range", what, value));
}
void CheckTime(double dt_s) {
  Check(dt_s > 0 && std::isfinite(dt_s), "a sampling interval of", dt_s);
}

std::vector<double> TakeAxis(std::span<const Vec3> f, int axis) {
  std::vector<double> x(f.size());
  std::transform(f.begin(), f.end(), x.begin(), [axis](const Vec3& v) { return v[axis]; });
  return x;
}

/// Returns the mean square above cutoff_Hz, summed over the three axes.
double CalcHighPassPower(std::span<const Vec3> f, double dt_s, double cutoff_Hz) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double rms = CalcHighPassRms(TakeAxis(f, axis), dt_s, cutoff_Hz);
    sum += rms * rms;
  }
  return sum;
}

/// Subtracts the least-squares line.
std::vector<double> Detrend(std::span<const double> f) {
  const std::size_t n = f.size();
  const double middle = 0.5 * static_cast<double>(n - 1);
  double mean = 0;
  double moment = 0;
  double spread = 0;
  for (std::size_t i = 0; i < n; ++i) mean += f[i] / static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double t = static_cast<double>(i) - middle;
    moment += t * (f[i] - mean);
    spread += t * t;
  }
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = f[i] - mean - moment / spread * (static_cast<double>(i) - middle);
  }
  return x;
}

/// Returns the value of a Hann window of n samples at sample i.
double CalcHann(std::size_t i, std::size_t n) {
  return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
}

double MeanSquare(std::span<const double> x) {
  double sum = 0;
  for (const double v : x) sum += v * v;
  return sum / static_cast<double>(x.size());
}

double MaxAbs(std::span<const double> x) {
  double max = 0;
  for (const double v : x) max = std::max(max, std::abs(v));
  return max;
}

/// Calculates the Fourier transform in place; the size must be a power of two.
void Transform(std::vector<std::complex<double>>& x) {
  const std::size_t n = x.size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1;
    for (; (j & bit) != 0; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(x[i], x[j]);
  }
  std::vector<std::complex<double>> turns(n / 2);
  for (std::size_t k = 0; k < n / 2; ++k) {
    turns[k] = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n));
  }
  for (std::size_t length = 2; length <= n; length <<= 1) {
    for (std::size_t start = 0; start < n; start += length) {
      for (std::size_t k = 0; k < length / 2; ++k) {
        const std::complex<double> even = x[start + k];
        const std::complex<double> odd = x[start + k + length / 2] * turns[k * (n / length)];
        x[start + k] = even + odd;
        x[start + k + length / 2] = even - odd;
      }
    }
  }
}

std::size_t CalcPowerOfTwo(std::size_t at_least) {
  std::size_t n = 1;
  while (n < at_least) n <<= 1;
  return n;
}

/// Returns the sums of x_i x_(i+lag) for all lags from 0 on.
std::vector<double> Correlate(std::span<const double> x) {
  std::vector<std::complex<double>> z(CalcPowerOfTwo(2 * x.size()));
  std::copy(x.begin(), x.end(), z.begin());
  Transform(z);
  for (std::complex<double>& v : z) v = std::norm(v);
  Transform(z);
  std::vector<double> sums(x.size());
  for (std::size_t lag = 0; lag < x.size(); ++lag) sums[lag] = z[lag].real() / static_cast<double>(z.size());
  return sums;
}

/// Returns the power at the frequency, averaged over Hann windows of `length` samples.
double CalcPowerAt(std::span<const double> f, std::size_t length, double periods_per_sample) {
  const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * periods_per_sample);
  double power = 0;
  int windows = 0;
  for (std::size_t start = 0; start + length <= f.size(); start += length / 2) {
    const std::vector<double> x = Detrend(f.subspan(start, length));
    std::complex<double> phase(1, 0);
    std::complex<double> sum(0, 0);
    for (std::size_t i = 0; i < length; ++i) {
      sum += CalcHann(i, length) * x[i] * phase;
      phase *= turn;
    }
    power += std::norm(sum);
    ++windows;
  }
  return power / windows;
}

/// Returns the mean square deviation from the mean.
double CalcVariance(std::span<const double> x) {
  double mean = 0;
  for (const double v : x) mean += v / static_cast<double>(x.size());
  double sum = 0;
  for (const double v : x) sum += (v - mean) * (v - mean);
  return sum / static_cast<double>(x.size());
}

/// Returns the growth rate per sample: the slope of a weighted fit to ln RMS of intervals of one period, in which
/// intervals with large values have larger weights. Each interval's mean is subtracted, since the straight line that
/// Detrend() removed from a decaying signal does not fit it locally.
double CalcGrowth(std::span<const double> x, std::size_t period) {
  double w = 0, wt = 0, wy = 0, wtt = 0, wty = 0;
  const double scale = MeanSquare(x);
  for (std::size_t start = 0; start + period <= x.size(); start += period) {
    const double ms = CalcVariance(x.subspan(start, period)) / scale;
    if (!(ms > 0)) continue;
    const double t = static_cast<double>(start);
    const double y = 0.5 * std::log(ms);
    w += ms, wt += ms * t, wy += ms * y, wtt += ms * t * t, wty += ms * t * y;
  }
  const double spread = wtt * w - wt * wt;
  return spread > 0 ? (wty * w - wt * wy) / spread : 0;
}

}  // namespace

double CalcNoise(std::span<const Vec3> f_N, double dt_s, double from_Hz) {
  CheckTime(dt_s);
  if (f_N.size() < 3 || !IsFinite(f_N)) return kNaN;
  return std::sqrt(CalcHighPassPower(f_N, dt_s, from_Hz));
}

double CalcJustNoticeable_N(double force_N) {
  return 0.07 * std::max(force_N, 0.5);
}

TickSteps CalcTickSteps(std::span<const Vec3> f_N) {
  if (f_N.size() < 2 || !IsFinite(f_N)) return {kNaN, kNaN};
  std::vector<double> steps;
  steps.reserve(f_N.size() - 1);
  for (std::size_t i = 1; i < f_N.size(); ++i) {
    const double noticed_N = CalcJustNoticeable_N(glm::length(f_N[i - 1]));
    steps.push_back(glm::length(f_N[i] - f_N[i - 1]) / noticed_N);
  }
  const double max = *std::max_element(steps.begin(), steps.end());
  return {CalcPercentile(std::move(steps), 0.999), max};
}

double CalcTotalVariation(std::span<const double> f) {
  if (f.size() < 2 || !IsFinite(f)) return kNaN;
  double total = 0;
  for (std::size_t i = 1; i < f.size(); ++i) total += std::abs(f[i] - f[i - 1]);
  const auto [lowest, highest] = std::minmax_element(f.begin(), f.end());
  return *highest > *lowest ? total / (*highest - *lowest) : 1;
}

Toggles CountToggles(std::span<const double> f, double dt_s, double min_reversal) {
  CheckTime(dt_s);
  Check(min_reversal >= 0, "a hysteresis of", min_reversal);
  if (f.size() < 2 || !IsFinite(f)) return {kNaN, kNaN};
  int contacts = 0;
  int turns = 0;
  int direction = 0;  // of the signal: 1 up, -1 down, 0 unknown yet
  double low = f[0];
  double high = f[0];  // like `low`, an extreme since the signal last reversed
  for (std::size_t i = 1; i < f.size(); ++i) {
    if ((f[i] != 0) != (f[i - 1] != 0)) ++contacts;
    low = std::min(low, f[i]);
    high = std::max(high, f[i]);
    if (direction != -1 && high - f[i] > min_reversal) {
      if (direction == 1) ++turns;
      direction = -1;
      low = f[i];
    } else if (direction != 1 && f[i] - low > min_reversal) {
      if (direction == -1) ++turns;
      direction = 1;
      high = f[i];
    }
  }
  const double time_s = static_cast<double>(f.size() - 1) * dt_s;
  return {contacts / time_s, turns / time_s};
}

double CalcLineProminence_dB(std::span<const double> f, double dt_s, double f_Hz) {
  CheckTime(dt_s);
  Check(f_Hz > 0 && f_Hz * dt_s <= 0.5, "a frequency of", f_Hz);
  const double at = f_Hz * dt_s;  // periods per sample
  // Each window is a quarter of the signal, so that there are seven of them, but at least 8 periods long.
  const auto n = static_cast<double>(f.size());
  const double min_length = 8 / at;
  if (n < 64 || n < min_length || !IsFinite(f)) return kNaN;
  const auto length = static_cast<std::size_t>(std::max({n / 4, min_length, 64.0}));
  const double bin = 1 / static_cast<double>(length);
  // A Hann window makes a line four bins wide; the bins from 4 to 10 on either side are the surroundings.
  std::vector<double> around;
  for (int k = 4; k <= 10; ++k) {
    if (at - k * bin > bin) around.push_back(CalcPowerAt(f, length, at - k * bin));
    if (at + k * bin <= 0.5) around.push_back(CalcPowerAt(f, length, at + k * bin));
  }
  const double nothing = std::pow(1e-9 * MaxAbs(f) * static_cast<double>(length), 2);
  const double power = CalcPowerAt(f, length, at) + nothing;
  const double usual = CalcPercentile(std::move(around), 0.5) + nothing;
  return usual > 0 ? 10 * std::log10(power / usual) : 0;
}

Oscillation FindOscillation(std::span<const double> f, double dt_s, double min_amplitude) {
  CheckTime(dt_s);
  if (f.size() < 16 || !IsFinite(f)) return {kNaN, kNaN, kNaN, kNaN, false};
  Oscillation found;
  const std::vector<double> x = Detrend(f);
  found.amplitude = std::sqrt(2 * MeanSquare(x));
  if (!(found.amplitude > 1e-12 * MaxAbs(f))) {
    found.amplitude = 0;
    return found;
  }
  // Autocorrelation, in which the value at each lag is divided by the maximum possible for the two overlapping parts.
  std::vector<double> r = Correlate(x);
  const std::size_t lags = x.size() / 3;
  double head = r[0];
  double tail = r[0];
  for (std::size_t lag = 0; lag <= lags; ++lag) {
    const double max = std::sqrt(std::max(0.0, head) * std::max(0.0, tail));
    r[lag] = max > 1e-12 * static_cast<double>(x.size()) * found.amplitude * found.amplitude ? r[lag] / max : 0;
    head -= x[x.size() - 1 - lag] * x[x.size() - 1 - lag];
    tail -= x[lag] * x[lag];
  }
  std::size_t first = 1;
  while (first <= lags && r[first] > 0) ++first;
  const auto is_peak = [&](std::size_t i) { return r[i] > 0 && r[i] >= r[i - 1] && r[i] > r[i + 1]; };
  double highest = 0;
  for (std::size_t i = first + 1; i < lags; ++i) {
    if (is_peak(i)) highest = std::max(highest, r[i]);
  }
  if (highest == 0) return found;
  // A periodic signal has peaks of about the same height at all multiples of the period, so the first one counts, at
  // its maximum.
  std::size_t top = 0;
  for (std::size_t i = first + 1; i < lags; ++i) {
    if (top != 0 && r[i] < 0.9 * highest) break;
    if (r[i] >= 0.9 * highest && is_peak(i) && (top == 0 || r[i] > r[top])) top = i;
  }
  const double bend = r[top - 1] - 2 * r[top] + r[top + 1];
  const double period = static_cast<double>(top) + (bend < 0 ? 0.5 * (r[top - 1] - r[top + 1]) / bend : 0);
  found.correlation = highest;
  found.frequency_Hz = 1 / (period * dt_s);
  const double growth = CalcGrowth(x, static_cast<std::size_t>(std::lround(period)));
  found.log_decrement = -growth * period;
  const bool dies_out = growth * static_cast<double>(x.size()) < std::log(0.9);
  found.is_limit_cycle = found.correlation > 0.5 && found.amplitude > min_amplitude && !dies_out;
  return found;
}

// The shape is from the literature: a U with its minimum between 150 and 200 Hz, below 0.01 um in some people. Above
// 40 Hz it falls towards this minimum more steeply (Brisben, Hsiao and Johnson 1999, abstract: a cylinder of 32 mm
// grasped in the hand) than the 12 dB per octave for a probe on the skin (Gescheider and Verrillo 1979). The figures
// are from memory, approximate the mean over people, and are accurate to a factor of 3 (10 dB) at best. Check them
// before quoting a sensation level.
double CalcVibrationThreshold_um(double f_Hz) {
  struct Point {
    double f_Hz, um;
  };
  static constexpr std::array<Point, 8> kThreshold = {
      {{10, 20}, {20, 8}, {40, 1.2}, {80, 0.15}, {150, 0.03}, {200, 0.03}, {300, 0.06}, {500, 0.3}}};
  if (!(f_Hz > kThreshold.front().f_Hz)) return kThreshold.front().um;
  for (std::size_t i = 1; i < kThreshold.size(); ++i) {
    const Point& a = kThreshold[i - 1];
    const Point& b = kThreshold[i];
    if (f_Hz <= b.f_Hz) return a.um * std::pow(b.um / a.um, std::log(f_Hz / a.f_Hz) / std::log(b.f_Hz / a.f_Hz));
  }
  return kThreshold.back().um;
}

double CalcSensationLevel_dB(std::span<const double> f_N, double dt_s, double mass_kg) {
  CheckTime(dt_s);
  Check(mass_kg > 0 && std::isfinite(mass_kg), "a mass of", mass_kg);
  constexpr double kMin_s = 0.5;
  constexpr double kNothing_dB = -200;
  const std::size_t n = f_N.size();
  if (n < 16 || static_cast<double>(n) * dt_s < kMin_s * (1 - 1e-9) || !IsFinite(f_N)) return kNaN;
  const std::vector<double> x = Detrend(f_N);
  std::vector<std::complex<double>> z(CalcPowerOfTwo(n));
  double window_power = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double w = CalcHann(i, n);
    z[i] = w * x[i];
    window_power += w * w;
  }
  Transform(z);
  double level_dB = kNothing_dB;
  for (int band = 10; band <= 27; ++band) {
    const double centre_Hz = std::pow(10, 0.1 * band);  // 10, 12.6, 15.8 ... 501 Hz
    const double from_Hz = centre_Hz * std::pow(10, -0.05);
    const double to_Hz = std::min(centre_Hz * std::pow(10, 0.05), 0.5 / dt_s);
    double mean_square = 0;
    for (std::size_t k = 1; k < z.size() / 2; ++k) {
      const double f_Hz = static_cast<double>(k) / (static_cast<double>(z.size()) * dt_s);
      if (f_Hz >= from_Hz && f_Hz < to_Hz) {
        mean_square += 2 * std::norm(z[k]) / (static_cast<double>(z.size()) * window_power);
      }
    }
    const double w = 2 * std::numbers::pi * centre_Hz;
    const double x_um = 1e6 * std::sqrt(2 * mean_square) / (mass_kg * w * w);
    if (x_um > 0) level_dB = std::max(level_dB, 20 * std::log10(x_um / CalcVibrationThreshold_um(centre_Hz)));
  }
  return level_dB;
}

double CalcTurn_deg(std::span<const Vec3> f_N, double fraction, double min_N) {
  Check(fraction >= 0 && fraction <= 1, "a fraction of", fraction);
  if (f_N.size() < 2 || !IsFinite(f_N)) return kNaN;
  std::vector<double> turns_deg;
  for (std::size_t i = 1; i < f_N.size(); ++i) {
    const Vec3& a = f_N[i - 1];
    const Vec3& b = f_N[i];
    if (!(glm::length(a) > min_N) || !(glm::length(b) > min_N)) continue;
    turns_deg.push_back(std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) * 180 / std::numbers::pi);
  }
  return turns_deg.empty() ? 0 : CalcPercentile(std::move(turns_deg), fraction);
}

double CalcAliveness(std::span<const Vec3> p_mm, double dt_s) {
  CheckTime(dt_s);
  constexpr double kMin_s = 1;
  const std::size_t n = p_mm.size();
  if (n < 3 || static_cast<double>(n) * dt_s < kMin_s * (1 - 1e-9) || !IsFinite(p_mm)) return kNaN;
  return std::sqrt(std::max(0.0, CalcHighPassPower(p_mm, dt_s, 1) - CalcHighPassPower(p_mm, dt_s, 20)));
}

}  // namespace kerf
