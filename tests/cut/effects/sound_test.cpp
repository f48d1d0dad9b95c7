// Sound: its spectral lines are at the frequencies of motor and teeth, it is louder under load, it never clicks, and it
// contains nothing above half the sampling rate or aliased from there.
#include "cut/effects/sound/sound.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "base/core/heap_guard.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "support/cuts.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// Returns the amplitude of a signal's line at a frequency, with a Hann window.
double LineOf(const std::vector<float>& x, double hz, double rate_Hz) {
  std::complex<double> sum = 0;
  double weights = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double w =
        1 - std::cos(2 * std::numbers::pi * (static_cast<double>(i) + 0.5) / static_cast<double>(x.size()));
    sum +=
        w * static_cast<double>(x[i]) * std::polar(1.0, -2 * std::numbers::pi * hz * static_cast<double>(i) / rate_Hz);
    weights += w;
  }
  return 2 * std::abs(sum) / weights;
}

double RmsOf(const std::vector<float>& x) {
  double sum = 0;
  for (const float v : x) sum += static_cast<double>(v) * static_cast<double>(v);
  return std::sqrt(sum / static_cast<double>(x.size()));
}

ToneParams WithoutNoise() {
  ToneParams params;
  params.noise_level = 0;
  return params;
}

/// Renders `ticks` ticks of the same frame, after `left_out` ticks that are discarded.
std::vector<float> Hold(Tone& tone, ToneFrame frame, int ticks, int left_out = 10) {
  std::vector<float> samples;
  for (int i = 0; i < ticks + left_out; ++i) {
    tone.Render(frame, samples);
    if (i + 1 == left_out) samples.clear();
  }
  return samples;
}

const ToneFrame kCutting{0.001F, 125, 30, 0.1F, 0.1F, 0.4F};

TEST(Tone, HasLinesAtMotorAndToothFrequencies) {
  Tone tone(WithoutNoise(), 24);
  const std::vector<float> x = Hold(tone, kCutting, 1000);
  ASSERT_EQ(x.size(), 48000u);  // one second: bins of 1 Hz
  // Motor and runout both have a line at the spindle's frequency; these are added with the same phase.
  const auto amplitudes = tone.CalcAmplitudes(kCutting);
  EXPECT_NEAR(LineOf(x, 125, 48000), amplitudes[Tone::kMotor1] + amplitudes[Tone::kRunout], 1e-6);
  EXPECT_NEAR(LineOf(x, 3000, 48000), amplitudes[Tone::kPassing], 1e-6);
  EXPECT_NEAR(LineOf(x, 1500, 48000), amplitudes[Tone::kSet], 1e-6);
  EXPECT_NEAR(LineOf(x, 875, 48000), amplitudes[Tone::kWhine], 1e-6);
  EXPECT_GT(amplitudes[Tone::kPassing], 0.02);
  // The line is at the centre of its bin: with a Hann window, the two neighbouring bins contain half of its amplitude
  // and all others nothing.
  for (const double line_Hz : {125.0, 3000.0}) {
    const double line = LineOf(x, line_Hz, 48000);
    for (const double off_Hz : {-1.0, 1.0}) EXPECT_NEAR(LineOf(x, line_Hz + off_Hz, 48000), 0.5 * line, 1e-6);
    for (const double off_Hz : {-3.0, -2.0, 2.0, 3.0}) EXPECT_LT(LineOf(x, line_Hz + off_Hz, 48000), 1e-6);
  }
}

TEST(Tone, ContainsOnlyItsLines) {
  // By Parseval's theorem, the mean square is half the sum of the squares of all amplitudes, where amplitudes at the
  // same frequency are added first.
  Tone tone(WithoutNoise(), 24);
  const std::vector<float> x = Hold(tone, kCutting, 1000);
  auto a = tone.CalcAmplitudes(kCutting);
  a[Tone::kMotor1] += a[Tone::kRunout];
  a[Tone::kRunout] = 0;
  const double square = std::inner_product(a.begin(), a.end(), a.begin(), 0.0);
  EXPECT_NEAR(RmsOf(x), std::sqrt(0.5 * square), 1e-6);
}

TEST(Tone, IsLouderUnderLoad) {
  double before = 0;
  for (const float load : {0.0F, 0.1F, 0.5F, 1.0F, 4.0F, 20.0F}) {
    Tone tone(ToneParams{}, 24);
    const std::vector<float> x = Hold(tone, {0.001F, 125, 20 * load, 0, 0, 0.2F * load}, 500);
    EXPECT_GT(RmsOf(x), 1.05 * before) << load;
    before = RmsOf(x);
  }
}

TEST(Tone, NoiseIsBroadAndWithinItsBand) {
  ToneParams params;
  params.motor_level = params.teeth_level = 0;
  Tone tone(params, 24);
  const std::vector<float> x = Hold(tone, {0.001F, 125, 1000, 0, 0, 0}, 2000);
  // Power in a hundred bins from a frequency on: similar throughout the band, and at least 10 dB lower far outside it.
  const auto density = [&](double hz) {
    double sum = 0;
    for (int i = 0; i < 100; ++i) sum += std::pow(LineOf(x, hz + 2 * i, 48000), 2);
    return sum;
  };
  const double middle = density(2500);
  for (const double hz : {1200.0, 4000.0, 5500.0}) {
    EXPECT_GT(density(hz), 0.2 * middle) << hz;
    EXPECT_LT(density(hz), 5 * middle) << hz;
  }
  EXPECT_LT(density(20), 0.1 * middle);
  EXPECT_LT(density(22000), 0.1 * middle);
}

TEST(Tone, IsSilentWithTheSpindleStopped) {
  Tone tone(ToneParams{}, 24);
  Hold(tone, kCutting, 20);
  ToneFrame stopped = kCutting;
  stopped.spindle_Hz = 0;
  std::vector<float> x = Hold(tone, stopped, 100, 1);  // the tick in which the sound fades out is left out
  for (const float v : x) ASSERT_EQ(v, 0);
}

TEST(Tone, NeverClicks) {
  // The difference between samples is at most the sum over the partials of amplitude * 2 pi f / rate, plus the change
  // of the amplitude itself, for any sequence of ticks.
  for (const double tick_s : {0.00025, 0.001, 0.0137}) {
    Tone tone(WithoutNoise(), 24);
    std::vector<float> x{0};
    ToneFrame before{};
    for (int i = 0; i < 800; ++i) {
      // The frames contain a ramp, a load that is switched on and off, a stall and a start.
      ToneFrame frame{static_cast<float>(tick_s), static_cast<float>(std::min(i, 400)) / 2, 0, 0, 0, 0};
      if (i % 50 > 25) frame.load_W = 100, frame.passing_N = 2, frame.set_N = 1;
      if (i > 600 && i < 650) frame.spindle_Hz = 0;
      const std::size_t from = x.size();
      tone.Render(frame, x);
      if (x.size() == from) continue;
      const auto was = tone.CalcAmplitudes(before), is = tone.CalcAmplitudes(frame);
      double bound = 1e-6;
      for (std::size_t n = 0; n < was.size(); ++n) {
        const double max_Hz = tone.orders()[n] * static_cast<double>(std::max(before.spindle_Hz, frame.spindle_Hz));
        bound += std::max(was[n], is[n]) * 2 *
                     std::sin(std::min(0.5 * std::numbers::pi, std::numbers::pi * max_Hz / 48000)) +
                 std::abs(is[n] - was[n]) / static_cast<double>(x.size() - from);
      }
      for (std::size_t k = from; k < x.size(); ++k) {
        ASSERT_LE(std::abs(static_cast<double>(x[k] - x[k - 1])), bound) << i << " " << tick_s;
      }
      before = frame;
    }
    EXPECT_EQ(x.size() - 1, static_cast<std::size_t>(800 * tick_s * 48000 + 0.01)) << tick_s;
  }
}

TEST(Tone, TickBoundariesAreInaudible) {
  // For a constant frame, the samples do not depend on the length of the ticks.
  Tone fine(WithoutNoise(), 24), coarse(WithoutNoise(), 24);
  ToneFrame frame = kCutting;
  const std::vector<float> a = Hold(fine, frame, 480, 20);
  frame.dt_s = 0.02F;
  ToneFrame first = kCutting;  // both begin with a tick of 1 ms, in which the tone fades in
  std::vector<float> b;
  coarse.Render(first, b);
  for (int i = 0; i < 25; ++i) coarse.Render(frame, b);
  b.erase(b.begin(), b.begin() + 20 * 48);
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-5) << i;
}

TEST(Tone, NothingIsAliased) {
  // With 64 teeth, from 20 250 rpm on, the first line of tooth passing is above 0.45 of the rate, 21.6 kHz, and would
  // be partly aliased.
  for (const float spindle_Hz : {338.0F, 347.0F, 359.0F, 410.0F, 733.0F}) {
    Tone tone(WithoutNoise(), 64);
    const ToneFrame frame{0.001F, spindle_Hz, 30, 0, 0, 0.4F};
    const std::vector<float> x = Hold(tone, frame, 1000);
    for (const double order : {64.0, 128.0}) {
      const double f = order * static_cast<double>(spindle_Hz);
      EXPECT_LT(LineOf(x, std::abs(std::remainder(f, 48000)), 48000), 1e-7) << spindle_Hz << " " << order;
    }
  }
}

TEST(Tone, ToleratesAnyFrame) {
  ToneParams params;
  params.motor_level = params.teeth_level = params.noise_level = 0.3;
  Tone tone(params, 24);
  std::vector<float> x;
  const float kNaN = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  for (const float value : {kNaN, kInf, -kInf, -1.0F, 1e30F, 3.0F}) {
    for (const float dt_s : {0.0F, 1e-6F, 0.001F, 1.0F, 7.0F, kNaN}) {
      tone.Render({dt_s, std::min(value, 1e6F), value, value, value, value}, x);
      tone.Render({dt_s, 125, value, value, value, value}, x);
    }
  }
  EXPECT_LE(x.size(), 2u * 6 * 2 * 48000 + 2000);
  for (const float v : x) ASSERT_LE(std::abs(v), 0.9F);
}

// ---- the effect

const Pose kAcross{Quat(std::sqrt(0.5), 0, std::sqrt(0.5), 0), Vec3(0)};  // spindle along x

Pose At(double z) {
  Pose X = kAcross;
  X.p_AB = {0, 0, z};
  return X;
}

struct Reported {
  double spindle_Hz, load_W, passing_N;
};

Reported ReadChannels(const EffectPlan& plan) {
  std::vector<double> channels(plan.channel_count());
  plan.Report(channels);
  const ToneReader reader(plan);
  const ToneFrame frame = reader.Read(0.001, channels);
  return {static_cast<double>(frame.spindle_Hz), static_cast<double>(frame.load_W),
          static_cast<double>(frame.passing_N)};
}

TEST(Sound, ReportsSpeedAndPowerOfTheCut) {
  SimulationParams params;
  SetEffect(params.effects, "sound", "cutting_share", 0.5);
  SetEffect(params.effects, "sound", "passing_share", 0.1);
  Simulation simulation(test::MakeBox(Pose{}, {8, 30, 16}, 0.4), params, At(19.2));
  const EffectPlan& plan = EffectsOf(std::as_const(simulation));
  TickOutput out;
  double z = 19.2;
  for (int i = 0; i < 1500; ++i) out = simulation.Tick({At(z -= 0.002), 0.001, -6000});
  ASSERT_GT(out.thrust_sum_N, 1);
  EXPECT_FLOAT_EQ(static_cast<float>(ReadChannels(plan).spindle_Hz), 100);
  // Half of the thrust, at the rim's speed of 2 pi 100 Hz 11 mm.
  EXPECT_NEAR(ReadChannels(plan).load_W, 0.5 * out.thrust_sum_N * 2 * std::numbers::pi * 100 * 0.011,
              1e-5 * ReadChannels(plan).load_W);
  EXPECT_NEAR(ReadChannels(plan).passing_N, 0.1 * out.thrust_sum_N / std::max(1.0, out.engaged_teeth), 1e-6);
  // The tool leaves the bone, and then the spindle is stopped.
  for (int i = 0; i < 500; ++i) out = simulation.Tick({At(z += 0.01), 0.001, 6000});
  EXPECT_EQ(ReadChannels(plan).load_W, 0);
  EXPECT_EQ(ReadChannels(plan).passing_N, 0);
  simulation.Tick({At(z), 0.001, 0});
  EXPECT_EQ(ReadChannels(plan).spindle_Hz, 0);
}

TEST(Sound, UsesPowerAndLinesOfMoreAccurateEffects) {
  CoupledParams params;
  params.effects.emplace_back("tangential_force");
  params.effects.emplace_back("tooth_vibration");
  params.effects.emplace_back("sound");
  CoupledSimulation simulation(test::MakeBox(Pose{}, {8, 30, 16}, 0.4), params, At(19.2));
  const EffectPlan& plan = EffectsOf(std::as_const(simulation));
  std::vector<double> channels(plan.channel_count());
  const ToneReader reader(plan);
  double z = 19.2;
  for (int i = 0; i < 1000; ++i) {
    const HeapGuard guard;
    simulation.Tick({.X_WH = At(z -= 0.002)});
    plan.Report(channels);
    reader.Read(0.001, channels);
  }
  const auto find = [&](std::string_view effect, std::string_view channel) {
    for (const EffectPlan::Entry& entry : plan.entries()) {
      for (std::size_t i = 0; i < entry.info->channels.size(); ++i) {
        if (entry.info->name == effect && entry.info->channels[i].name == channel)
          return static_cast<float>(channels[entry.first_channel + i]);
      }
    }
    return -1.0F;
  };
  const ToneFrame frame = reader.Read(0.001, channels);
  EXPECT_GT(frame.load_W, 0);
  EXPECT_EQ(frame.load_W, find("tangential_force", "cutting_W"));
  EXPECT_GT(frame.passing_N, 0);
  EXPECT_EQ(frame.passing_N, find("tooth_vibration", "passing_N"));
  EXPECT_EQ(frame.set_N, find("tooth_vibration", "set_N"));
  EXPECT_EQ(frame.runout_N, find("tooth_vibration", "runout_N"));
}

TEST(Sound, LeavesCutAndForceBitIdentical) {
  const auto run = [](bool sound) {
    CoupledParams params;
    if (sound) params.effects.emplace_back("sound");
    CoupledSimulation simulation(test::MakeBox(Pose{}, {8, 30, 16}, 0.4), params, At(19.2));
    std::vector<Vec3> forces;
    double z = 19.2;
    for (int i = 0; i < 800; ++i) forces.push_back(simulation.Tick({.X_WH = At(z -= 0.002)}).f_H_W_N);
    return std::pair{simulation.UpdateBone().CalcHash(), forces};
  };
  EXPECT_EQ(run(true), run(false));
}

}  // namespace
}  // namespace kerf
