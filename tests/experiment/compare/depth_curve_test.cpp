// Tests of resampling and of differences, compared with closed forms.
#include "experiment/compare/depth_curve.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>

#include "experiment/compare/difference.h"

namespace kerf {
namespace {

/// Samples `force`, a function of the depth, `per_mm` times per mm from `from_mm` to `to_mm`. Each sample is taken in
/// the middle of its tick.
template <typename F>
std::vector<DepthSample> Sample(F force, double from_mm, double to_mm, int per_mm) {
  std::vector<DepthSample> samples;
  const int count = static_cast<int>(std::lround((to_mm - from_mm) * per_mm));
  for (int i = 0; i < count; ++i) {
    const double depth = from_mm + (i + 0.5) / per_mm;
    samples.push_back({depth, force(depth), 2 * force(depth), 3 * force(depth), 4 * force(depth)});
  }
  return samples;
}

std::vector<std::size_t> AllBins(const DepthGrid& grid) {
  std::vector<std::size_t> bins(grid.count);
  std::iota(bins.begin(), bins.end(), 0);
  return bins;
}

TEST(DepthCurve, BinOfALinearForceHasTheValueAtItsMiddle) {
  const DepthGrid grid{0.1, 50};
  const DepthCurve curve = CalcDepthCurve(Sample([](double h) { return 3 * h + 1; }, 0, 5, 200), grid);
  ASSERT_EQ(curve.reach, 50u);
  EXPECT_EQ(curve.interpolated, 0u);
  for (std::size_t i = 0; i < grid.count; ++i) {
    // The 20 samples lie symmetrically about the middle, so their mean is exact except for rounding.
    EXPECT_NEAR(curve.force_N[i], 3 * grid.Centre(i) + 1, 1e-12);
    EXPECT_NEAR(curve.magnitude_N[i], 2 * curve.force_N[i], 1e-12);
    EXPECT_NEAR(curve.thrust_N[i], 3 * curve.force_N[i], 1e-12);
    EXPECT_NEAR(curve.teeth[i], 4 * curve.force_N[i], 1e-12);
  }
}

TEST(DepthCurve, MeanOfABinIsTheIntegralOverIt) {
  // The mean of sin over a bin [a, b] is (cos a - cos b) / (b - a). With 100 samples per bin, the midpoint rule has an
  // error of (0.1/100)^2 / 24.
  const DepthGrid grid{0.1, 60};
  const DepthCurve curve = CalcDepthCurve(Sample([](double h) { return std::sin(h); }, 0, 6, 1000), grid);
  for (std::size_t i = 0; i < grid.count; ++i) {
    const double a = 0.1 * static_cast<double>(i);
    EXPECT_NEAR(curve.force_N[i], (std::cos(a) - std::cos(a + 0.1)) / 0.1, 1e-7);
  }
}

TEST(DepthCurve, BinsPassedBetweenTwoTicksAreInterpolatedAndCounted) {
  // With one tick per 0.5 mm and bins of 0.1 mm, four of five bins contain no tick. A linear force is interpolated
  // exactly.
  const DepthGrid grid{0.1, 30};
  std::vector<DepthSample> samples;
  for (int i = 0; i < 6; ++i) {
    const double depth = 0.05 + 0.5 * i;
    samples.push_back({depth, 7 * depth, 7 * depth, 0, 0});
  }
  const DepthCurve curve = CalcDepthCurve(samples, grid);
  EXPECT_EQ(curve.interpolated, 20u);
  EXPECT_EQ(curve.reach, 26u);  // the last tick is at 2.55 mm
  for (std::size_t i = 0; i < 26; ++i) EXPECT_NEAR(curve.force_N[i], 7 * grid.Centre(i), 1e-12) << i;
  for (std::size_t i = 26; i < 30; ++i) EXPECT_TRUE(std::isnan(curve.force_N[i])) << i;
}

TEST(DepthCurve, SamplesOutsideTheGridAreLeftOut) {
  const DepthGrid grid{1, 2};
  const DepthCurve curve =
      CalcDepthCurve({{-0.1, 100, 0, 0, 0}, {0.5, 1, 0, 0, 0}, {1.5, 2, 0, 0, 0}, {2.0, 100, 0, 0, 0}}, grid);
  EXPECT_EQ(curve.force_N, (std::vector<double>{1, 2}));
}

TEST(DepthCurve, OnlySamplesDeeperThanAllBeforeCount) {
  // The path goes down to 3, back to 1 and down to 4. The second pass from 1 to 3 runs through the kerf.
  std::vector<DepthSample> samples;
  for (const double depth : {1.0, 2.0, 3.0, 2.0, 1.0, 2.0, 3.0, 4.0}) samples.push_back({depth, depth, 0, 0, 0});
  const std::vector<DepthSample> advance = TakeAdvance(samples);
  std::vector<double> depths;
  for (const DepthSample& s : advance) depths.push_back(s.depth_mm);
  EXPECT_EQ(depths, (std::vector<double>{1, 2, 3, 4}));
}

TEST(Difference, OfASineFromZeroIsItsRootMeanSquareAndAmplitude) {
  // Over whole periods the rms is A / sqrt(2), and the peak A is at a quarter of a period. With bins of 1/1000 of the
  // period both agree to within 1e-5 of A.
  const DepthGrid grid{0.002, 3000};
  std::vector<double> sine, zero(grid.count, 0);
  for (std::size_t i = 0; i < grid.count; ++i) sine.push_back(5 * std::sin(std::numbers::pi * grid.Centre(i)));
  const Difference d = CalcDifference(sine, zero, AllBins(grid), grid.step_mm);
  EXPECT_EQ(d.bins, 3000u);
  EXPECT_NEAR(d.rms_N, 5 / std::sqrt(2.0), 5e-5);
  EXPECT_NEAR(d.mean_N, 0, 1e-12);
  EXPECT_NEAR(std::abs(d.peak_N), 5, 5e-5);
  EXPECT_NEAR(std::fmod(d.peak_depth_mm, 1), 0.5, 0.0021);
}

TEST(Difference, OfTwoParabolasMatchesTheClosedForm) {
  // For h^2 and 2 h^2 - 3 over 0..3 the difference is 3 - h^2. Its mean square is integral (3 - h^2)^2 / 3 = 9 - 18 +
  // 81/5 = 7.2. The largest difference, -6, is at the end. With bins of 0.001 mm the midpoint rule is accurate to 1e-6,
  // and the value at the end to the slope times half a bin, 0.003.
  const DepthGrid grid{0.001, 3000};
  std::vector<double> a, b;
  for (std::size_t i = 0; i < grid.count; ++i) {
    const double h = grid.Centre(i);
    a.push_back(h * h);
    b.push_back(2 * h * h - 3);
  }
  const Difference d = CalcDifference(a, b, AllBins(grid), grid.step_mm);
  EXPECT_NEAR(d.rms_N, std::sqrt(7.2), 1e-5);
  EXPECT_NEAR(d.peak_N, -6, 0.004);
  EXPECT_NEAR(d.peak_depth_mm, 3, 0.001);
  EXPECT_NEAR(d.mean_N, 3, 1e-5);
  EXPECT_NEAR(d.reference_mean_N, 3, 1e-5);
}

TEST(Difference, FromItselfIsZero) {
  const std::vector<double> a{1, 2, 3};
  const Difference d = CalcDifference(a, a, {0, 1, 2}, 0.1);
  EXPECT_EQ(d.rms_N, 0);
  EXPECT_EQ(d.peak_N, 0);
  EXPECT_EQ(CalcDifference(a, a, {}, 0.1).bins, 0u);
}

TEST(Difference, LeavesOutBinsThatEitherCurveLacks) {
  const double none = std::nan("");
  const Difference d = CalcDifference({1, none, 5}, {none, 1, 2}, {0, 1, 2}, 0.1);
  EXPECT_EQ(d.bins, 1u);
  EXPECT_EQ(d.rms_N, 3);
}

}  // namespace
}  // namespace kerf
