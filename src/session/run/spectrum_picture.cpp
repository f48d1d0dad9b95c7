#include "session/run/spectrum_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "base/core/spectrum.h"

namespace kerf {
namespace {

constexpr double kLongest_s = 1;
constexpr double kShortest_s = 1.0 / 64;
constexpr double kSamplesPerPeriod = 2.6;  // samples per period of the highest line
constexpr double kCarriedFraction = 0.4;   // lines up to this fraction of the tick rate are in the force
constexpr double kChirpReserve = 4;        // of the sampling: a chirp that turns back has lines above its frequency
constexpr std::size_t kLabelledLines = 5;  // of a stroke

/// Returns the largest amplitude near a frequency, mN.
double FindPeak(const SpectrumTrack::Spectrum& spectrum, double hz) {
  const auto bin = static_cast<std::size_t>(std::lround(hz * spectrum.seconds));
  double mN = 0;
  for (std::size_t k = bin - std::min<std::size_t>(bin, 3); k < std::min(bin + 4, spectrum.mN.size()); ++k)
    mN = std::max(mN, spectrum.mN[k]);
  return mN;
}

std::string ShowPeak(double hz, double mN) {
  return fmt::format("{:.0f} Hz: {:.{}f} mN", hz, mN, mN < 10 ? 1 : 0);
}

/// Returns the highest of the lines at multiples of the strokes' rate, each with its label.
PlotSeries LabelStrokeLines(const SpectrumTrack::Spectrum& spectrum, double end_Hz) {
  std::vector<std::pair<double, double>> lines;  // mN, Hz
  for (int k = 1; k * spectrum.spindle_Hz < end_Hz; ++k) {
    const double hz = k * spectrum.spindle_Hz;
    lines.emplace_back(FindPeak(spectrum, hz), hz);
  }
  std::sort(lines.begin(), lines.end(), std::greater<>());
  lines.resize(std::min(lines.size(), kLabelledLines));
  PlotSeries marks;
  marks.colour = Rgb8{33, 37, 43};
  marks.width = 0;
  marks.marker = 5;
  for (const auto& [mN, hz] : lines) {
    marks.x.push_back(hz);
    marks.y.push_back(mN);
    marks.point_labels.push_back(ShowPeak(hz, mN));
  }
  return marks;
}

}  // namespace

SpectrumTrack::SpectrumTrack(const EffectPlan& plan)
    : effect_(dynamic_cast<const ToothVibrationEffect*>(plan.Find("tooth_vibration"))) {
  if (effect_ == nullptr) return;
  for (std::size_t n = 0; n < orders_.size(); ++n) orders_[n] = effect_->lines()[n].order;
}

void SpectrumTrack::Take(double dt_s) {
  if (effect_ == nullptr) return;
  std::array<double, 5> channels{};
  effect_->Report(channels);
  if (effect_->spindle_Hz() > 0) passes_ = channels[4] / effect_->spindle_Hz();
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
  // With a stroke the lines are chirps: their angle is pi s / pitch at the displacement s (tooth_vibration.cpp).
  const bool strokes = orders_[ToothVibrationEffect::kRunout] == 0;
  const double swing_rad = strokes ? std::numbers::pi * passes_ / 4 : 0;  // largest angle
  spectrum.strokes = strokes;
  spectrum.teeth = strokes ? 0 : orders_[ToothVibrationEffect::kPassing2] / 2;
  spectrum.has_set = orders_[ToothVibrationEffect::kSet] > 0;
  spectrum.carried_Hz = strokes ? 0 : kCarriedFraction / static_cast<double>(moments_[begin].dt_s);
  // Highest frequency as a multiple of the spindle's.
  const double multiple = strokes ? kChirpReserve * highest * std::max(swing_rad, 1.0) : highest;
  const std::size_t samples =
      std::bit_ceil(static_cast<std::size_t>(std::ceil(kSamplesPerPeriod * multiple * fastest_Hz * spectrum.seconds)));
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
    const double phase_rad = 2 * std::numbers::pi * std::fmod(turns, 1);
    Vec3 f(0);
    for (std::size_t n = 0; n < orders_.size(); ++n) {
      if (orders_[n] == 0) continue;
      const double angle_rad = strokes ? swing_rad * std::sin(phase_rad) : phase_rad;
      const std::complex<double> turn = std::polar(1.0, orders_[n] * angle_rad);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::complex<double> a(from.amplitude_N[n][axis]), b(to.amplitude_N[n][axis]);
        f[static_cast<int>(axis)] += ((a + fraction * (b - a)) * turn).real();
      }
    }
    if (strokes && std::cos(phase_rad) < 0) f.y = -f.y;
    for (std::size_t axis = 0; axis < 3; ++axis) x[axis].push_back(f[static_cast<int>(axis)]);
    turns += static_cast<double>(to.spindle_Hz) * step_s;
  }
  spectrum.spindle_Hz = turns / spectrum.seconds;
  spectrum.passing_Hz = passes_ * spectrum.spindle_Hz;
  spectrum.mN.assign(samples / 2, 0);
  for (const auto& axis : x) {
    const std::vector<double> N = CalcAmplitudes(axis);
    for (std::size_t k = 0; k < N.size(); ++k) spectrum.mN[k] = std::hypot(spectrum.mN[k], 1000 * N[k]);
  }
  return spectrum;
}

PlotSpec MakeSpectrumPlot(const SpectrumTrack::Spectrum& spectrum, const std::string& name) {
  PlotSpec plot;
  plot.title = name + ": tooth vibration";
  const std::string speed = spectrum.strokes
                                ? fmt::format("n = {:.0f} strokes a minute, lines at multiples of {:.3g} Hz",
                                              60 * spectrum.spindle_Hz, spectrum.spindle_Hz)
                                : fmt::format("n = {:.0f} rpm, N = {} teeth", 60 * spectrum.spindle_Hz, spectrum.teeth);
  plot.caption = fmt::format(
      "what single teeth add to the mean force, before the limit max_N; {:g} s from {:.2f} s on, where it was "
      "highest\n{}",
      spectrum.seconds, spectrum.begin_s, speed);
  plot.x.label = fmt::format("frequency (Hz), in steps of {:g}", 1 / spectrum.seconds);
  plot.y.label = "force amplitude (mN)";
  plot.y.log = true;
  const double highest_mN = *std::max_element(spectrum.mN.begin(), spectrum.mN.end());
  plot.y.upper = std::pow(10, std::ceil(std::log10(highest_mN) + 0.35));
  plot.y.lower = *plot.y.upper * 1e-6;
  // Teeth of a stroke pass fastest in its middle, pi / 2 times as fast as on average.
  const double end_Hz = spectrum.strokes
                            ? std::max(2.3 * std::numbers::pi / 2 * spectrum.passing_Hz, 4 * spectrum.spindle_Hz)
                            : 2.3 * spectrum.teeth * spectrum.spindle_Hz;
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
  if (spectrum.strokes) {
    plot.series.push_back(LabelStrokeLines(spectrum, end_Hz));
    plot.lines.push_back(
        {true, spectrum.passing_Hz, fmt::format("teeth passing, mean: {:.0f} Hz", spectrum.passing_Hz)});
    return plot;
  }
  const auto mark = [&](double order, const std::string& what, double above) {
    const double hz = order * spectrum.spindle_Hz;
    const double mN = FindPeak(spectrum, hz);
    if (mN < 1e-5 * highest_mN) return;
    plot.notes.push_back({hz + 0.012 * end_Hz, mN * above, fmt::format("{}\n{}", what, ShowPeak(hz, mN)), {}});
  };
  mark(1, "n / 60, runout", 0.8);
  if (spectrum.has_set) mark(0.5 * spectrum.teeth, "N n / 120, set", 1);
  if (spectrum.teeth > 1) mark(spectrum.teeth, "N n / 60, teeth passing", 1);
  mark(2.0 * spectrum.teeth, "2 N n / 60", 1);
  if (spectrum.carried_Hz < end_Hz) {
    plot.bands.push_back({0, spectrum.carried_Hz, "", {219, 234, 245}});
    plot.caption += "; blue: to the hand";
  }
  return plot;
}

bool WriteSpectrumPicture(const SpectrumTrack::Spectrum& spectrum, const std::string& name, const std::string& path) {
  if (spectrum.mN.empty()) return false;
  WritePlot(MakeSpectrumPlot(spectrum, name), path);
  return true;
}

}  // namespace kerf
