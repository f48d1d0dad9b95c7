// Compares percentiles with their definition.
#include "base/core/percentiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace kerf {
namespace {

TEST(Percentiles, AreNearestRank) {
  std::vector<double> values;
  for (int i = 1000; i >= 1; --i) values.push_back(i);
  const Percentiles times = CalcPercentiles(values);
  EXPECT_EQ(times.count, 1000U);
  EXPECT_EQ(times.p50_us, 500);
  EXPECT_EQ(times.p99_us, 990);
  EXPECT_EQ(times.p999_us, 999);
  EXPECT_EQ(times.max_us, 1000);
  EXPECT_EQ(CalcPercentiles(std::vector<double>{7}).p999_us, 7);
  EXPECT_EQ(CalcPercentiles(std::vector<double>{}).max_us, 0);
}

TEST(Percentiles, AreTheSmallestValuesThatEnoughValuesDoNotExceed) {
  std::mt19937 random(7);
  for (int count = 1; count <= 60; ++count) {
    std::vector<float> values(static_cast<std::size_t>(count));
    for (float& value : values) value = static_cast<float>(random() % 20);  // some are equal
    for (int percent = 0; percent <= 100; ++percent) {
      float expected = *std::max_element(values.begin(), values.end());
      for (const float value : values) {
        const auto below = std::count_if(values.begin(), values.end(), [&](float other) { return other <= value; });
        if (100 * below >= percent * count) expected = std::min(expected, value);
      }
      ASSERT_EQ(CalcPercentile(values, 0.01 * percent), expected) << percent << " % of " << count;
    }
  }
}

TEST(Percentiles, OfAHistogramAreThoseOfItsTimesUpToTheWidthOfABucket) {
  LogHistogram histogram;
  std::vector<double> times_us;
  for (int i = 1; i <= 5000; ++i) {
    times_us.push_back(0.5 * i);
    histogram.Add(500 * i);
  }
  const Percentiles exact = CalcPercentiles(times_us);
  const Percentiles counted = CalcPercentiles(histogram);
  EXPECT_EQ(counted.count, exact.count);
  EXPECT_EQ(counted.max_us, exact.max_us);
  for (double Percentiles::*p : {&Percentiles::p50_us, &Percentiles::p99_us, &Percentiles::p999_us}) {
    EXPECT_GE(counted.*p, exact.*p);
    EXPECT_LE(counted.*p, 1.032 * exact.*p);
  }
}

}  // namespace
}  // namespace kerf
