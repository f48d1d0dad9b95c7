#include "base/core/spectrum.h"

#include <gtest/gtest.h>

#include <cmath>

#include "kerf/error.h"

namespace kerf {
namespace {

TEST(Spectrum, HasTheAmplitudesOfSines) {
  std::vector<double> x;
  for (int i = 0; i < 1024; ++i) {
    const double turn = 2 * std::acos(-1.0) * i / 1024;
    x.push_back(0.5 + 3 * std::sin(100 * turn + 0.3) + 0.25 * std::cos(301 * turn));
  }
  const std::vector<double> a = CalcAmplitudes(x);
  ASSERT_EQ(a.size(), 512u);
  EXPECT_NEAR(a[0], 0.5, 1e-12);
  EXPECT_NEAR(a[100], 3, 1e-12);
  EXPECT_NEAR(a[99], 1.5, 1e-12);
  EXPECT_NEAR(a[101], 1.5, 1e-12);
  EXPECT_NEAR(a[301], 0.25, 1e-12);
  for (const std::size_t k : {3u, 98u, 102u, 250u, 299u, 303u, 511u}) EXPECT_LT(a[k], 1e-12) << k;
}

TEST(Spectrum, RefusesLengthsThatAreNoPowerOfTwo) {
  EXPECT_THROW(CalcAmplitudes(std::vector<double>(1000)), Error);
  EXPECT_THROW(CalcAmplitudes(std::vector<double>(2)), Error);
  EXPECT_NO_THROW(CalcAmplitudes(std::vector<double>(4)));
}

}  // namespace
}  // namespace kerf
