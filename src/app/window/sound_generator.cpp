#include "app/window/sound_generator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace kerf {
namespace {

constexpr double kThere_mm = 0.2;  // distance at which the goal counts as reached
struct AlarmSound {
  double pitch_Hz;
  double from_mm;  // range
};
constexpr std::array<AlarmSound, kAlarmKinds> kAlarms{{{880, 3}, {1175, 3}, {587, 0.5}}};

constexpr double kAlarmLevel = 0.22;  // of each alarm; three of them and the saw stay below 1
constexpr double kSawLevel = 0.18;
constexpr double kQuietSaw = 0.35;  // loudness of an idle saw, as a fraction of kSawLevel
constexpr double kFullLoad_N = 8;
constexpr double kCyclesPerTurn = 2;  // of the tone
constexpr double kMaxSaw_Hz = 2500;
constexpr double kDroop = 0.08;  // fraction by which a load lowers the tone

double Sine(double cycles) {
  return std::sin(2 * std::numbers::pi * cycles);
}

/// Time constant of a level or frequency as a fraction per sample.
constexpr double Smoothing(double time_s) {
  return 1 / (time_s * SoundGenerator::kRate_Hz);
}

}  // namespace

Beep CalcAlarm(AlarmKind kind, std::optional<double> distance_mm) {
  const AlarmSound& sound = kAlarms[static_cast<std::size_t>(kind)];
  if (!distance_mm || std::isnan(*distance_mm) || *distance_mm > sound.from_mm) return {};
  constexpr double kSteady = std::numeric_limits<double>::infinity();
  if (*distance_mm < -kThere_mm) return {.per_s = kSteady, .pitch_Hz = 1.5 * sound.pitch_Hz};
  if (*distance_mm < kThere_mm) return {.per_s = kSteady, .pitch_Hz = sound.pitch_Hz};
  // 2 beeps per second at the edge of the range, 10 per second just before the goal.
  return {.per_s = 2 + 8 * (sound.from_mm - *distance_mm) / (sound.from_mm - kThere_mm), .pitch_Hz = sound.pitch_Hz};
}

SawTone CalcSawTone(double rpm, double force_N) {
  if (!std::isfinite(rpm) || !std::isfinite(force_N) || std::abs(rpm) < 1) return {};
  const double load = std::clamp(std::abs(force_N) / kFullLoad_N, 0.0, 1.0);
  const double frequency_Hz = std::min(kMaxSaw_Hz, kCyclesPerTurn * std::abs(rpm) / 60);
  return {.frequency_Hz = frequency_Hz * (1 - kDroop * load), .level = kQuietSaw + (1 - kQuietSaw) * load};
}

void SoundGenerator::Fill(const SoundState& state, std::span<std::int16_t> samples) {
  std::array<Beep, kAlarmKinds> beeps;
  for (std::size_t i = 0; i < kAlarmKinds; ++i) {
    beeps[i] = CalcAlarm(static_cast<AlarmKind>(i), state.alarms_mm[i]);
    if (beeps[i].per_s > 0) voices_[i].pitch_Hz = beeps[i].pitch_Hz;
  }
  const SawTone saw = CalcSawTone(state.rpm, state.force_N);
  // A saw that was silent begins at its frequency.
  if (saw.level > 0 && saw_level_ < 1e-4) saw_Hz_ = saw.frequency_Hz;
  const double wanted_Hz = saw.level > 0 ? saw.frequency_Hz : saw_Hz_;
  const bool silent = state.muted || !(state.volume > 0);
  const double wanted_gain = silent ? 0 : std::min(state.volume, 1.0);
  constexpr double kGainStep = 1 / (kFade_s * kRate_Hz);

  for (std::int16_t& sample : samples) {
    double sum = 0;
    for (std::size_t i = 0; i < kAlarmKinds; ++i) {
      Voice& voice = voices_[i];
      const bool steady = std::isinf(beeps[i].per_s);
      if (!steady) voice.beat += beeps[i].per_s / kRate_Hz;
      voice.beat -= std::floor(voice.beat);
      const bool on = steady || (beeps[i].per_s > 0 && voice.beat < 0.5);
      voice.level += Smoothing(0.005) * ((on ? kAlarmLevel : 0) - voice.level);
      voice.phase += voice.pitch_Hz / kRate_Hz;
      voice.phase -= std::floor(voice.phase);
      sum += voice.level * Sine(voice.phase);
    }
    saw_Hz_ += Smoothing(0.05) * (wanted_Hz - saw_Hz_);
    saw_level_ += Smoothing(0.05) * (saw.level - saw_level_);
    saw_phase_ += saw_Hz_ / kRate_Hz;
    saw_phase_ -= std::floor(saw_phase_);
    // The harmonics make it sound like a motor. Their amplitudes add up to 1.
    sum +=
        kSawLevel * saw_level_ * (0.6 * Sine(saw_phase_) + 0.25 * Sine(2 * saw_phase_) + 0.15 * Sine(3 * saw_phase_));
    gain_ += std::clamp(wanted_gain - gain_, -kGainStep, kGainStep);
    sample = static_cast<std::int16_t>(std::lround(kPeak * gain_ * sum));
  }
}

}  // namespace kerf
