#include "session/run/spectrum_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "base/core/spectrum.h"
#include "view/plot/plot.h"

namespace kerf {
namespace {

constexpr double kLongest_s = 1;
constexpr double kShortest_s = 1.0 / 64;
constexpr double kSamplesPerPeriod = 2.6;  // samples per period of the highest line
constexpr double kCarriedFraction = 0.4;   // lines up to this fraction of the tick rate are in the force

}  // namespace

SpectrumTrack::SpectrumTrack(const EffectPlan& plan)
    : effect_(dynamic_cast<const ToothVibrationEffect*>(plan.Find("tooth_vibration"))) {
  if (effect_ == nullptr) return;
  for (std::size_t n = 0; n < orders_.size(); ++n) orders_[n] = effect_->lines()[n].order;
}

void SpectrumTrack::Take(double dt_s) {
  if (effect_ == nullptr) return;
  Moment moment{static_cast<float>(dt_s), static_cast<float>(effect_->spindle_Hz()), {}};
  for (std::size_t n = 0; n < orders_.size(); ++n) {
    for (std::size_t axis = 0; axis < 3; ++axis)
      moment.amplitude_N[n][axis] = std::complex<float>(effect_->lines()[n].amplitude_N[axis]);
  }
  moments_.push_back(moment);
}

SpectrumTrack::Spectrum SpectrumTrack::CalcSpectrum() const {
  Spectrum spectrum;
  const std::size_t count = moments_.size();
  // Cumulative sums of time and of the lines' squares.
  std::vector<double> time_s{0}, square{0};
  double fastest_Hz = 0;
  for (const Moment& moment : moments_) {
    double sum = 0;
    for (const auto& line : moment.amplitude_N) {
      for (const auto& a : line) sum += static_cast<double>(std::norm(a));
    }
    const double dt_s = static_cast<double>(moment.dt_s);
    time_s.push_back(time_s.back() + dt_s);
    square.push_back(square.back() + sum * dt_s);
    if (sum > 0) fastest_Hz = std::max(fastest_Hz, static_cast<double>(moment.spindle_Hz));
  }
  const int highest = *std::max_element(orders_.begin(), orders_.end());
  if (!(square.back() > 0) || highest == 0 || !(fastest_Hz > 0)) return spectrum;
  spectrum.seconds = kLongest_s;
  while (spectrum.seconds > kShortest_s && spectrum.seconds > time_s.back()) spectrum.seconds /= 2;
  std::size_t begin = 0;
  double largest = -1;
  for (std::size_t from = 0, to = 0; from < count; ++from) {
    while (to < count && time_s[to] - time_s[from] < spectrum.seconds - 1e-9) ++to;
    if (time_s[to] - time_s[from] < spectrum.seconds - 1e-9) break;
    if (square[to] - square[from] > largest) largest = square[to] - square[from], begin = from;
  }
  if (largest < 0) return {};
  spectrum.begin_s = time_s[begin];
  spectrum.teeth = orders_[ToothVibrationEffect::kPassing];
  spectrum.carried_Hz = kCarriedFraction / static_cast<double>(moments_[begin].dt_s);
  const std::size_t samples =
      std::bit_ceil(static_cast<std::size_t>(std::ceil(kSamplesPerPeriod * highest * fastest_Hz * spectrum.seconds)));
  const double step_s = spectrum.seconds / static_cast<double>(samples);
  std::array<std::vector<double>, 3> x;
  for (auto& axis : x) axis.reserve(samples);
  double turns = 0;
  std::size_t tick = begin;
  for (std::size_t i = 0; i < samples; ++i) {
    const double now_s = time_s[begin] + step_s * static_cast<double>(i);
    while (tick + 1 < count && time_s[tick + 1] <= now_s) ++tick;
    const Moment& to = moments_[tick];
    const Moment& from = moments_[tick > 0 ? tick - 1 : 0];
    const double length_s = time_s[tick + 1] - time_s[tick];
    const double fraction = length_s > 0 ? std::clamp((now_s - time_s[tick]) / length_s, 0.0, 1.0) : 1;
    Vec3 f(0);
    for (std::size_t n = 0; n < orders_.size(); ++n) {
      const std::complex<double> turn = std::polar(1.0, 2 * std::numbers::pi * std::fmod(orders_[n] * turns, 1));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::complex<double> a(from.amplitude_N[n][axis]), b(to.amplitude_N[n][axis]);
        f[static_cast<int>(axis)] += ((a + fraction * (b - a)) * turn).real();
      }
    }
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis].push_back(f[static_cast<int>(axis)]);
    turns += static_cast<double>(to.spindle_Hz) * step_s;
  }
  spectrum.spindle_Hz = turns / spectrum.seconds;
  spectrum.mN.assign(samples / 2, 0);
  for (const auto& axis : x) {
    const std::vector<double> N = CalcAmplitudes(axis);
    for (std::size_t k = 0; k < N.size(); ++k) spectrum.mN[k] = std::hypot(spectrum.mN[k], 1000 * N[k]);
  }
  return spectrum;
}

bool WriteSpectrumPicture(const SpectrumTrack::Spectrum& spectrum, const std::string& name, const std::string& path) {
  if (spectrum.mN.empty()) return false;
  PlotSpec plot;
  plot.title = name + ": tooth vibration";
  plot.caption = fmt::format(
      "what single teeth add to the mean force; {:g} s from {:.2f} s on, where it was highest; n = {:.0f} rpm, N = {} "
      "teeth",
      spectrum.seconds, spectrum.begin_s, 60 * spectrum.spindle_Hz, spectrum.teeth);
  plot.x.label = fmt::format("frequency (Hz), in steps of {:g}", 1 / spectrum.seconds);
  plot.y.label = "force amplitude (mN)";
  plot.y.log = true;
  const double highest_mN = *std::max_element(spectrum.mN.begin(), spectrum.mN.end());
  plot.y.upper = std::pow(10, std::ceil(std::log10(highest_mN) + 0.35));
  plot.y.lower = *plot.y.upper * 1e-6;
  const double end_Hz = 2.3 * spectrum.teeth * spectrum.spindle_Hz;
  plot.x.lower = 0;
  plot.x.upper = end_Hz;
  PlotSeries curve;
  curve.label = "force";
  for (std::size_t k = 0; k < spectrum.mN.size(); ++k) {
    const double hz = static_cast<double>(k) / spectrum.seconds;
    if (hz > end_Hz) break;
    curve.x.push_back(hz);
    curve.y.push_back(std::max(spectrum.mN[k], *plot.y.lower));
  }
  plot.series.push_back(curve);
  const auto mark = [&](double order, const std::string& what, double above) {
    const double hz = order * spectrum.spindle_Hz;
    const auto bin = static_cast<std::size_t>(std::lround(hz * spectrum.seconds));
    if (bin >= spectrum.mN.size()) return;
    double mN = 0;
    for (std::size_t k = bin - std::min<std::size_t>(bin, 3); k < std::min(bin + 4, spectrum.mN.size()); ++k)
      mN = std::max(mN, spectrum.mN[k]);
    if (mN < 1e-5 * highest_mN) return;
    plot.notes.push_back(
        {hz + 0.012 * end_Hz, mN * above, fmt::format("{}\n{:.0f} Hz: {:.{}f} mN", what, hz, mN, mN < 10 ? 1 : 0), {}});
  };
  mark(1, "n / 60, runout", 0.8);
  mark(0.5 * spectrum.teeth, "N n / 120, set", 1);
  mark(spectrum.teeth, "N n / 60, teeth passing", 1);
  mark(2.0 * spectrum.teeth, "2 N n / 60", 1);
  if (spectrum.carried_Hz < end_Hz) {
    plot.bands.push_back({0, spectrum.carried_Hz, "", {219, 234, 245}});
    plot.caption += "; blue: to the hand";
  }
  WritePlot(plot, path);
  return true;
}

}  // namespace kerf
