// High-pass RMS of sines, whose RMS is known.
#include "base/core/high_pass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kDt_s = 0.001;

std::vector<double> MakeSine(double f_Hz, double amplitude, int n = 5000) {
  std::vector<double> x;
  for (int i = 0; i < n; ++i) x.push_back(amplitude * std::sin(2 * std::numbers::pi * f_Hz * i * kDt_s));
  return x;
}

/// Returns the gain of the filter applied forwards and backwards: |H|^2 = r^4 / (1 + r^4), where r is the ratio of the
/// bilinear frequencies.
double CalcGain(double f_Hz, double cutoff_Hz) {
  const double r = std::tan(std::numbers::pi * f_Hz * kDt_s) / std::tan(std::numbers::pi * cutoff_Hz * kDt_s);
  return std::pow(r, 4) / (1 + std::pow(r, 4));
}

TEST(HighPass, GainIsThatOfTwoButterworthPasses) {
  for (const double f : {10.0, 20.0, 40.0, 150.0, 400.0}) {
    // The sines have whole periods; end effects at low frequencies are below 2 %.
    EXPECT_NEAR(CalcHighPassRms(MakeSine(f, 3), kDt_s, 20) / (3 / std::numbers::sqrt2), CalcGain(f, 20), 0.02) << f;
  }
  EXPECT_NEAR(CalcHighPassRms(MakeSine(20, 1), kDt_s, 20), 0.5 / std::numbers::sqrt2, 0.005);
}

TEST(HighPass, SlowMotionAndStraightLinesGiveZero) {
  EXPECT_LT(CalcHighPassRms(MakeSine(0.5, 10), kDt_s, 20), 1e-3);
  std::vector<double> line;
  for (int i = 0; i < 1000; ++i) line.push_back(5 + 0.02 * i);
  EXPECT_LT(CalcHighPassRms(line, kDt_s, 20), 1e-9);
}

TEST(HighPass, TimeReversalHasNoEffect) {
  // The filter has zero phase, so reversing time has no effect. Tested with a step off the middle, to 1e-9 of its
  // height.
  std::vector<double> step(3000, 0.0);
  for (std::size_t i = 1234; i < step.size(); ++i) step[i] = 1;
  const double forwards = CalcHighPassRms(step, kDt_s, 20);
  EXPECT_GT(forwards, 1e-3);
  const std::vector<double> backwards(step.rbegin(), step.rend());
  EXPECT_NEAR(CalcHighPassRms(backwards, kDt_s, 20), forwards, 1e-9);
}

TEST(HighPass, SampleBySampleResultIsTheSame) {
  // Truncating the backward pass causes a relative error of exp(-44), and the sums have up to 1e5 terms, so 1e-12
  // covers rounding with a margin.
  for (const double dt_s : {0.001, 0.00025, 0.004}) {
    for (const int n : {0, 1, 2, 3, 4, 50, 251, 252, 253, 1001, 4096, 4700, 5000, 10'000, 100'000}) {
      std::vector<double> x;
      double walk = 3;
      unsigned dice = 12345;
      for (int i = 0; i < n; ++i) {
        dice = 1664525 * dice + 1013904223;
        walk += 1e-3 * (static_cast<double>(dice >> 8) / (1 << 24) - 0.5);
        x.push_back(walk + (i > n / 2 ? 1 : 0) + 0.01 * std::sin(0.3 * i));
      }
      HighPassRms rms(dt_s, 20);
      for (const double value : x) rms.Add(value);
      const double whole = CalcHighPassRms(x, dt_s, 20);
      EXPECT_NEAR(rms.Finish(), whole, 1e-12 * whole) << n << " samples every " << dt_s;
      EXPECT_EQ(rms.count(), x.size());
    }
  }
  EXPECT_THROW(HighPassRms(0.001, 500), Error);
}

TEST(HighPass, RefusesFrequenciesThatTheSamplingCannotRepresent) {
  for (const double f : {0.0, -1.0, 500.0, 1e9, std::nan("")}) {
    EXPECT_THROW(CalcHighPassRms(MakeSine(1, 1, 10), kDt_s, f), Error);
  }
  EXPECT_EQ(CalcHighPassRms(MakeSine(1, 1, 2), kDt_s, 20), 0);
}

}  // namespace
}  // namespace kerf
