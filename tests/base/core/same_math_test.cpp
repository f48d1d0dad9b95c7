// Compares the functions with those for long double, of which the C library has only one version. Special values must
// be exact.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <random>

#include "base/core/hash.h"

namespace kerf {
namespace {

// Hides a value from the compiler, so that functions of it are not evaluated at compile time.
double Hide(double x) {
  volatile double hidden = x;
  return hidden;
}

double CalcUlps(double got, long double exact) {
  const double nearest = static_cast<double>(exact);
  if (got == nearest) return 0;
  const double ulp = std::nextafter(std::abs(nearest), std::numeric_limits<double>::infinity()) - std::abs(nearest);
  return static_cast<double>(std::abs(static_cast<long double>(got) - exact)) / ulp;
}

TEST(SameMath, ErrorIsAtMostOneUnitInTheLastPlace) {
  struct Function {
    const char* name;
    double (*ours)(double);
    long double (*exact)(long double);
    double lower, upper;
  };
  const Function functions[] = {
      {"sin", [](double x) { return std::sin(x); }, [](long double x) { return std::sin(x); }, -1e3, 1e3},
      {"cos", [](double x) { return std::cos(x); }, [](long double x) { return std::cos(x); }, -1e3, 1e3},
      {"tan", [](double x) { return std::tan(x); }, [](long double x) { return std::tan(x); }, -1.5, 1.5},
      {"asin", [](double x) { return std::asin(x); }, [](long double x) { return std::asin(x); }, -1, 1},
      {"acos", [](double x) { return std::acos(x); }, [](long double x) { return std::acos(x); }, -1, 1},
      {"atan", [](double x) { return std::atan(x); }, [](long double x) { return std::atan(x); }, -50, 50},
      {"exp", [](double x) { return std::exp(x); }, [](long double x) { return std::exp(x); }, -300, 300},
      {"expm1", [](double x) { return std::expm1(x); }, [](long double x) { return std::expm1(x); }, -3, 3},
      {"log", [](double x) { return std::log(x); }, [](long double x) { return std::log(x); }, 1e-9, 1e4},
      {"log1p", [](double x) { return std::log1p(x); }, [](long double x) { return std::log1p(x); }, -0.9, 10},
      {"log10", [](double x) { return std::log10(x); }, [](long double x) { return std::log10(x); }, 1e-9, 1e4},
      {"cbrt", [](double x) { return std::cbrt(x); }, [](long double x) { return std::cbrt(x); }, -1e4, 1e4},
      {"pow 1.5", [](double x) { return std::pow(x, Hide(1.5)); }, [](long double x) { return std::pow(x, 1.5L); }, 0,
       1e3},
      {"pow -0.687", [](double x) { return std::pow(x, Hide(-0.687)); },
       [](long double x) { return std::pow(x, static_cast<long double>(-0.687)); }, 1e-3, 1e3},
      {"atan2", [](double x) { return std::atan2(x, Hide(0.7)); },
       [](long double x) { return std::atan2(x, static_cast<long double>(0.7)); }, -5, 5},
      {"hypot", [](double x) { return std::hypot(x, Hide(3)); }, [](long double x) { return std::hypot(x, 3.0L); }, -9,
       9},
  };
  std::mt19937_64 dice(1);
  for (const Function& f : functions) {
    std::uniform_real_distribution<double> any(f.lower, f.upper);
    double worst = 0;
    for (int i = 0; i < 20'000; ++i) {
      const double x = any(dice);
      worst = std::max(worst, CalcUlps(f.ours(x), f.exact(static_cast<long double>(x))));
    }
    // SLEEF guarantees 1.0 ULP; the comparison itself is accurate to 0.001.
    EXPECT_LE(worst, 1.001) << f.name;
    EXPECT_TRUE(std::isnan(f.ours(std::numeric_limits<double>::quiet_NaN()))) << f.name;
  }
}

TEST(SameMath, SpecialValuesAreExact) {
  double ten = 1;
  for (int k = 0; k <= 22; ++k, ten *= 10) {
    EXPECT_EQ(std::pow(Hide(10), Hide(k)), ten);
    EXPECT_EQ(std::log10(Hide(ten)), k);
  }
  for (int k = -1000; k <= 1000; k += 7) EXPECT_EQ(std::pow(Hide(2), Hide(k)), std::ldexp(1.0, k));
  for (int k = 0; k < 200; ++k) {
    EXPECT_EQ(std::pow(Hide(k), Hide(2)), static_cast<double>(k) * k);
    EXPECT_EQ(std::pow(Hide(k), Hide(3)), static_cast<double>(k) * k * k);
    EXPECT_EQ(std::cbrt(Hide(static_cast<double>(k) * k * k)), k);
    EXPECT_EQ(std::hypot(Hide(3.0 * k), Hide(4.0 * k)), 5.0 * k);
  }
  EXPECT_EQ(std::sin(Hide(0)), 0);
  EXPECT_EQ(std::cos(Hide(0)), 1);
  EXPECT_EQ(std::exp(Hide(0)), 1);
  EXPECT_EQ(std::log(Hide(1)), 0);
  EXPECT_EQ(std::acos(Hide(1)), 0);
  EXPECT_EQ(std::pow(Hide(0), Hide(0)), 1);
  EXPECT_EQ(std::exp(Hide(-1e4)), 0);
  EXPECT_EQ(std::exp(Hide(1e4)), std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::signbit(std::sin(Hide(-0.0))));
  EXPECT_EQ(std::atan2(Hide(0.0), Hide(-1.0)), std::acos(-1.0));
}

// A hash of many values must be the same on all machines. It has been verified on x86-64 with the C library's variants
// for old and new processors; with the C library's own functions there would be two different hashes, depending on the
// processor.
TEST(SameMath, ResultsAreTheSameOnAllMachines) {
  std::uint64_t hash = 0;
  for (int i = 1; i < 20'000; ++i) {
    const double x = Hide(0.0123 * i);
    for (const double y : {std::sin(x), std::cos(x), std::pow(x, Hide(1.37)), std::atan2(x, Hide(1.3)), std::exp(-x),
                           std::acos(1 / (1 + x)), std::log(x)}) {
      hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(y));
    }
  }
  EXPECT_EQ(hash, 1683373699759168608u);
}

}  // namespace
}  // namespace kerf
