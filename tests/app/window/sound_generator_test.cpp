// Tests of the samples of the window's sound.
#include "app/window/sound_generator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <vector>

namespace kerf {
namespace {

constexpr double kRate_Hz = SoundGenerator::kRate_Hz;

std::vector<std::int16_t> Play(SoundGenerator& generator, const SoundState& state, double seconds) {
  // The generator is called with blocks of 10 ms, as by the audio thread.
  std::vector<std::int16_t> samples(static_cast<std::size_t>(seconds * kRate_Hz));
  for (std::size_t i = 0; i < samples.size(); i += 480) {
    generator.Fill(state, std::span(samples).subspan(i, std::min<std::size_t>(480, samples.size() - i)));
  }
  return samples;
}

SoundState MakeAlarm(AlarmKind kind, double distance_mm) {
  SoundState state;
  state.alarms_mm[static_cast<std::size_t>(kind)] = distance_mm;
  state.volume = 1;
  return state;
}

/// Returns the frequency from the rising zero crossings.
double MeasureFrequency(const std::vector<std::int16_t>& samples) {
  int crossings = 0;
  std::size_t first = 0;
  std::size_t last = 0;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (samples[i - 1] > 0 || samples[i] <= 0) continue;
    if (crossings++ == 0) first = i;
    last = i;
  }
  return crossings < 2 ? 0 : (crossings - 1) * kRate_Hz / static_cast<double>(last - first);
}

int CountBeeps(const std::vector<std::int16_t>& samples) {
  // A beep begins where a loud sample follows 20 ms without one. The shortest pause between beeps is 50 ms long, of
  // which 20 ms are the decay.
  int beeps = 0;
  std::size_t quiet = 960;
  for (const std::int16_t sample : samples) {
    if (std::abs(sample) < 1500) {
      ++quiet;
      continue;
    }
    beeps += quiet >= 960 ? 1 : 0;
    quiet = 0;
  }
  return beeps;
}

int FindPeak(const std::vector<std::int16_t>& samples) {
  int peak = 0;
  for (const std::int16_t sample : samples) peak = std::max(peak, std::abs(static_cast<int>(sample)));
  return peak;
}

TEST(Alarm, DistinguishesFarNearAndBeyond) {
  for (const AlarmKind kind : {AlarmKind::kDepth, AlarmKind::kStructure, AlarmKind::kMargin}) {
    EXPECT_EQ(CalcAlarm(kind, std::nullopt).per_s, 0);
    EXPECT_EQ(CalcAlarm(kind, 10).per_s, 0);
    EXPECT_EQ(CalcAlarm(kind, std::numeric_limits<double>::quiet_NaN()).per_s, 0);
    EXPECT_GT(CalcAlarm(kind, 0.45).per_s, 0);
    EXPECT_LT(CalcAlarm(kind, 0.45).per_s, CalcAlarm(kind, 0.3).per_s);  // faster towards the goal
    EXPECT_NEAR(CalcAlarm(kind, 0.2).per_s, 10, 1e-9);
    EXPECT_TRUE(std::isinf(CalcAlarm(kind, 0).per_s));
    EXPECT_TRUE(std::isinf(CalcAlarm(kind, -1).per_s));
    EXPECT_GT(CalcAlarm(kind, -1).pitch_Hz, CalcAlarm(kind, 0).pitch_Hz);
  }
  EXPECT_NEAR(CalcAlarm(AlarmKind::kDepth, 3).per_s, 2, 1e-12);
  EXPECT_NE(CalcAlarm(AlarmKind::kDepth, 0).pitch_Hz, CalcAlarm(AlarmKind::kStructure, 0).pitch_Hz);
  EXPECT_NE(CalcAlarm(AlarmKind::kDepth, 0).pitch_Hz, CalcAlarm(AlarmKind::kMargin, 0).pitch_Hz);
}

TEST(SoundGenerator, AlarmsHaveTheirFrequency) {
  for (const AlarmKind kind : {AlarmKind::kDepth, AlarmKind::kStructure, AlarmKind::kMargin}) {
    for (const double distance_mm : {0.0, -1.0}) {
      SoundGenerator generator;
      const SoundState state = MakeAlarm(kind, distance_mm);
      Play(generator, state, 0.1);
      // Counting crossings over a second is accurate to the sampling time at both ends: two samples in 48000.
      const double expected_Hz = CalcAlarm(kind, distance_mm).pitch_Hz;
      EXPECT_NEAR(MeasureFrequency(Play(generator, state, 1)), expected_Hz, 1e-4 * expected_Hz);
    }
  }
}

TEST(SoundGenerator, BeepsAsOftenAsAsked) {
  for (const double distance_mm : {3.0, 2.0, 1.0, 0.3}) {
    SoundGenerator generator;
    const double per_s = CalcAlarm(AlarmKind::kDepth, distance_mm).per_s;
    // The count may differ by the beep that is under way at the end.
    EXPECT_NEAR(CountBeeps(Play(generator, MakeAlarm(AlarmKind::kDepth, distance_mm), 10)), 10 * per_s, 1)
        << distance_mm;
  }
}

TEST(SoundGenerator, SawToneFollowsSpeedAndLoad) {
  double before_Hz = 0;
  for (const double rpm : {1000.0, 7500.0, -15000.0, 40000.0}) {
    SoundGenerator generator;
    SoundState state;
    state.rpm = rpm;
    state.volume = 1;
    Play(generator, state, 0.5);
    const double measured_Hz = MeasureFrequency(Play(generator, state, 1));
    EXPECT_NEAR(measured_Hz, CalcSawTone(rpm, 0).frequency_Hz, 1e-3 * measured_Hz) << rpm;
    EXPECT_GT(measured_Hz, before_Hz);
    before_Hz = measured_Hz;
  }
  EXPECT_LT(CalcSawTone(7500, 5).frequency_Hz, CalcSawTone(7500, 0).frequency_Hz);
  EXPECT_GT(CalcSawTone(7500, 5).level, CalcSawTone(7500, 0).level);
  EXPECT_LE(CalcSawTone(7500, 1e6).level, 1);
  EXPECT_EQ(CalcSawTone(0, 5).level, 0);
  EXPECT_EQ(CalcSawTone(std::numeric_limits<double>::quiet_NaN(), 0).level, 0);

  SoundGenerator idle, loaded;
  SoundState state;
  state.rpm = 7500;
  const int quiet = FindPeak(Play(idle, state, 1));
  state.force_N = 8;
  EXPECT_GT(FindPeak(Play(loaded, state, 1)), 2 * quiet);
}

// With everything at its loudest, and with states that change abruptly every 10 ms.
TEST(SoundGenerator, IsBoundedAndDoesNotClick) {
  SoundGenerator generator;
  std::vector<std::int16_t> all;
  for (int i = 0; i < 400; ++i) {
    SoundState state;
    state.volume = i % 7 == 0 ? 0.3 : 5;  // beyond the range: as 1
    state.muted = i % 11 == 0;
    state.rpm = i % 3 == 0 ? 0 : 1e5;
    state.force_N = i % 2 == 0 ? 0 : 1e9;
    if (i % 5 != 0) state.alarms_mm = {i % 4 - 1.5, i % 6 - 2.5, 0.1 * (i % 20) - 1};
    const std::vector<std::int16_t> block = Play(generator, state, 0.01);
    all.insert(all.end(), block.begin(), block.end());
  }
  EXPECT_LE(FindPeak(all), SoundGenerator::kPeak);
  // The largest step of the sum of all tones at their amplitudes and frequencies (A 2 pi f / rate), plus the steps of
  // the envelopes (A / 240) and of the gain (1 / 480 of the whole).
  double max_step = 0;
  for (const double pitch_Hz : {1.5 * 880, 1.5 * 1175, 1.5 * 587}) {
    max_step += 0.22 * (2 * std::numbers::pi * pitch_Hz / kRate_Hz + 1.0 / 240);
  }
  max_step += 0.12 * (2 * std::numbers::pi * 2500 / kRate_Hz * (0.6 + 2 * 0.25 + 3 * 0.15) + 1.0 / 2400);
  max_step += (3 * 0.22 + 0.12) / 480;
  int largest = 0;
  for (std::size_t i = 1; i < all.size(); ++i) largest = std::max(largest, std::abs(all[i] - all[i - 1]));
  EXPECT_LE(largest, SoundGenerator::kPeak * max_step + 1);
  EXPECT_GT(largest, 100);  // something was played
}

TEST(SoundGenerator, MuteAndZeroVolumeGiveExactZeros) {
  SoundState loud = MakeAlarm(AlarmKind::kStructure, -1);
  loud.rpm = 7500;
  SoundState muted = loud;
  muted.muted = true;
  SoundState off = loud;
  off.volume = 0;
  for (const SoundState& state : {muted, off}) {
    SoundGenerator generator;
    EXPECT_EQ(FindPeak(Play(generator, state, 0.5)), 0);  // from the start
    EXPECT_GT(FindPeak(Play(generator, loud, 0.5)), 5000);
    Play(generator, state, SoundGenerator::kFade_s);
    EXPECT_EQ(FindPeak(Play(generator, state, 0.5)), 0);
  }
}

TEST(SoundGenerator, VolumeScalesTheSound) {
  for (const double volume : {0.25, 0.5, 1.0}) {
    SoundGenerator generator;
    SoundState state = MakeAlarm(AlarmKind::kDepth, 0);
    state.volume = volume;
    Play(generator, state, 0.2);
    // The amplitude of one alarm, sampled at 55 points per cycle, of which the best is within 0.4 % of the crest.
    EXPECT_NEAR(FindPeak(Play(generator, state, 0.5)), volume * 0.22 * SoundGenerator::kPeak, 0.005 * 7040);
  }
}

TEST(SoundGenerator, NothingToHearIsSilence) {
  SoundGenerator generator;
  EXPECT_EQ(FindPeak(Play(generator, SoundState{}, 0.2)), 0);
}

}  // namespace
}  // namespace kerf
