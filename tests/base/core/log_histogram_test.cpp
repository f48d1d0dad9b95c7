#include "base/core/log_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

namespace kerf {
namespace {

TEST(LogHistogram, BucketsAreContiguousAndContainTheirTimes) {
  for (std::size_t i = 0; i + 1 < LogHistogram::kBuckets; ++i) {
    // Edges are whole nanoseconds: the next bucket begins 1 ns after the end of this one.
    EXPECT_NEAR(LogHistogram::LowerEdge_us(i + 1) - LogHistogram::UpperEdge_us(i), 1e-3, 1e-6) << i;
  }
  std::mt19937_64 random(3);
  for (int n = 0; n < 2000; ++n) {
    const auto ns = static_cast<std::int64_t>(std::exp2(std::uniform_real_distribution<double>(0, 40.9)(random)));
    const auto histogram = std::make_unique<LogHistogram>();
    histogram->Add(ns);
    std::size_t found = LogHistogram::kBuckets;
    for (std::size_t i = 0; i < LogHistogram::kBuckets; ++i) {
      if (histogram->count(i) > 0) found = i;
    }
    ASSERT_LT(found, LogHistogram::kBuckets);
    const double us = 1e-3 * static_cast<double>(ns);
    EXPECT_LE(LogHistogram::LowerEdge_us(found), us * (1 + 1e-12));
    EXPECT_GE(LogHistogram::UpperEdge_us(found), us * (1 - 1e-12));
    EXPECT_EQ(histogram->max_us(), us);
  }
}

TEST(LogHistogram, PercentilesAreAtMostABucketAboveTheSortedOnes) {
  std::mt19937_64 random(4);
  std::lognormal_distribution<double> draw(10, 1.5);
  const auto histogram = std::make_unique<LogHistogram>();
  std::vector<double> us;
  for (int i = 0; i < 20'000; ++i) {
    const auto ns = static_cast<std::int64_t>(draw(random));
    histogram->Add(ns);
    us.push_back(1e-3 * static_cast<double>(ns));
  }
  std::sort(us.begin(), us.end());
  for (const double fraction : {0.0, 0.01, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const double n = static_cast<double>(us.size());
    const double exact = us[static_cast<std::size_t>(std::max(0.0, std::ceil(fraction * n) - 1))];
    EXPECT_GE(histogram->CalcPercentile_us(fraction), exact * (1 - 1e-12)) << fraction;
    EXPECT_LE(histogram->CalcPercentile_us(fraction), exact * (1 + 1.0 / 32) + 1e-3) << fraction;  // a bucket's width
  }
  EXPECT_EQ(histogram->CalcPercentile_us(1), us.back());
  double sum = 0;
  for (const double t : us) sum += t;
  EXPECT_NEAR(histogram->CalcMean_us(), sum / static_cast<double>(us.size()), 1e-6 * sum);
  const auto above = static_cast<double>(std::count_if(us.begin(), us.end(), [](double t) { return t > 100; }));
  EXPECT_NEAR(static_cast<double>(histogram->CountAbove_us(100)), above, 0.05 * above);
}

TEST(LogHistogram, ClampsImpossibleTimes) {
  const auto histogram = std::make_unique<LogHistogram>();
  EXPECT_EQ(histogram->CalcPercentile_us(0.5), 0);
  EXPECT_EQ(histogram->CalcMean_us(), 0);
  histogram->Add(-5);
  EXPECT_EQ(histogram->CalcPercentile_us(0.5), 0);
  histogram->Add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram->total(), 2U);
  EXPECT_NEAR(histogram->max_us(), std::exp2(41) * 1e-3, 1);
}

}  // namespace
}  // namespace kerf
