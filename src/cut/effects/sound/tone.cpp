#include "cut/effects/sound/tone.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/core/hash.h"

namespace kerf {
namespace {

constexpr double kPassBand = 0.40;  // relative to the sampling rate
constexpr double kStopBand = 0.45;
constexpr double kSpeedHalf_Hz = 20;  // spindle frequency at half loudness
constexpr double kIdle = 0.4;         // the motor's loudness without load, as a fraction of its maximum
constexpr double kNoiseFrom_Hz = 700, kNoiseTo_Hz = 6000;
// Fractions of the motor's level and of the teeth's level; each set sums to 1.
constexpr double kFractions[Tone::kPartials] = {0.35, 0.15, 0.1, 0.25, 0.15, 0.2, 0.25, 0.4, 0.15};

double Clean(float value) {
  return std::isfinite(value) ? std::max(0.0, static_cast<double>(value)) : 0;
}

/// Returns 0 at 0, 1/2 at `half`, and approaches 1.
double Saturate(double value, double half) {
  return value / (value + half);
}

}  // namespace

Tone::Tone(const ToneParams& params, double teeth)
    : params_(params),
      fine_fraction_(1 - std::exp(-2 * std::numbers::pi * kNoiseTo_Hz / params.rate_Hz)),
      slow_fraction_(1 - std::exp(-2 * std::numbers::pi * kNoiseFrom_Hz / params.rate_Hz)) {
  orders_[kMotor1] = 1;
  orders_[kMotor2] = 2;
  orders_[kMotor3] = 3;
  orders_[kWhine] = params.motor_order;
  orders_[kWhine2] = 2 * params.motor_order;
  orders_[kRunout] = 1;
  orders_[kSet] = 0.5 * teeth;
  orders_[kPassing] = teeth;
  orders_[kPassing2] = 2 * teeth;
}

std::array<double, Tone::kPartials> Tone::CalcAmplitudes(const ToneFrame& frame) const {
  const double turning = Saturate(Clean(frame.spindle_Hz), kSpeedHalf_Hz);
  const double motor =
      params_.motor_level * turning * (kIdle + (1 - kIdle) * Saturate(Clean(frame.load_W), params_.half_W));
  const auto teeth = [&](float newton) {
    return params_.teeth_level * turning * Saturate(Clean(newton), params_.half_N);
  };
  std::array<double, kPartials> amplitudes{};
  for (std::size_t n = kMotor1; n <= kWhine2; ++n) amplitudes[n] = kFractions[n] * motor;
  amplitudes[kRunout] = kFractions[kRunout] * teeth(frame.runout_N);
  amplitudes[kSet] = kFractions[kSet] * teeth(frame.set_N);
  amplitudes[kPassing] = kFractions[kPassing] * teeth(frame.passing_N);
  amplitudes[kPassing2] = kFractions[kPassing2] * teeth(frame.passing_N);
  return amplitudes;
}

double Tone::CalcNoise(const ToneFrame& frame) const {
  return params_.noise_level * Saturate(Clean(frame.spindle_Hz), kSpeedHalf_Hz) *
         Saturate(Clean(frame.load_W), params_.half_W);
}

/// Returns noise between about 0.7 and 6 kHz, -1 to 1: both filters return weighted means of their input.
double Tone::NextNoise() {
  const double white = static_cast<double>(MixHash(++random_state_) >> 11) * 0x1p-52 - 1;
  fine_ += fine_fraction_ * (white - fine_);
  finer_ += fine_fraction_ * (fine_ - finer_);
  slow_ += slow_fraction_ * (finer_ - slow_);
  return 0.5 * (finer_ - slow_);
}

void Tone::Render(const ToneFrame& frame, std::vector<float>& samples) {
  const double spindle_Hz = Clean(frame.spindle_Hz);
  if (fresh_) spindle_Hz_ = spindle_Hz;
  fresh_ = false;
  owed_ += std::min(1.0, Clean(frame.dt_s)) * params_.rate_Hz;
  const int count = static_cast<int>(owed_);
  if (count == 0) return;
  owed_ -= count;
  const std::array<double, kPartials> amplitudes = CalcAmplitudes(frame);
  const double noise = CalcNoise(frame);
  for (int i = 1; i <= count; ++i) {
    const double fraction = static_cast<double>(i) / count;
    const double now_Hz = spindle_Hz_ + fraction * (spindle_Hz - spindle_Hz_);
    double sum = 0;
    for (std::size_t n = 0; n < kPartials; ++n) {
      const double of_rate = orders_[n] * now_Hz / params_.rate_Hz;
      turns_[n] += of_rate;
      turns_[n] -= std::floor(turns_[n]);
      const double amplitude = amplitudes_[n] + fraction * (amplitudes[n] - amplitudes_[n]);
      if (amplitude == 0 || of_rate >= kStopBand) continue;
      const double heard = std::min(1.0, (kStopBand - of_rate) / (kStopBand - kPassBand));
      sum += heard * amplitude * std::sin(2 * std::numbers::pi * turns_[n]);
    }
    const double noise_now = noise_amplitude_ + fraction * (noise - noise_amplitude_);
    if (noise_now > 0) sum += noise_now * NextNoise();
    samples.push_back(static_cast<float>(sum));
  }
  spindle_Hz_ = spindle_Hz;
  amplitudes_ = amplitudes;
  noise_amplitude_ = noise;
}

}  // namespace kerf
