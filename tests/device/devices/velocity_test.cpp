// Velocity from quantised positions.
#include "device/devices/velocity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace kerf {
namespace {

constexpr double kVelocityDt_s = 0.001;
constexpr double kQuantum_mm = 0.055;

double Quantise(double x) {
  return std::round(x / kQuantum_mm) * kQuantum_mm;
}

TEST(AdaptiveVelocity, IsExactForALineThatNeedsNoRounding) {
  AdaptiveVelocity velocity(1e-9);
  Vec3 v{0};
  for (int i = 0; i < 50; ++i) v = velocity.Update(Vec3(0.003, -0.001, 0) * double(i), kVelocityDt_s);
  EXPECT_NEAR(v.x, 3, 1e-9);
  EXPECT_NEAR(v.y, -1, 1e-9);
  EXPECT_EQ(v.z, 0);
}

TEST(AdaptiveVelocity, ErrorFallsWithTheWindow) {
  // At constant speed, the slope between the ends of a window of n steps is off by at most one quantum divided by the
  // window's time, since each end is off by half a quantum. The window is shortened only if rounding exceeds a quantum,
  // which never happens on a line.
  for (const int samples : {4, 16, 32}) {
    AdaptiveVelocity velocity(kQuantum_mm, samples);
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      const double v = velocity.Update(Vec3(Quantise(0.0173 * i), 0, 0), kVelocityDt_s).x;
      if (i > 40) worst = std::max(worst, std::abs(v - 17.3));
    }
    EXPECT_LE(worst, kQuantum_mm / ((samples - 1) * kVelocityDt_s) * (1 + 1e-9)) << samples;
    EXPECT_GT(worst, 0.1 * kQuantum_mm / ((samples - 1) * kVelocityDt_s)) << samples;
  }
}

TEST(AdaptiveVelocity, WindowShortensWhenMotionReverses) {
  // The speed changes abruptly from 100 mm/s to -100 mm/s; a fixed window of 15 steps would still give 0 after 7 ms.
  AdaptiveVelocity velocity(0.001);
  double x = 0;
  for (int i = 0; i < 100; ++i) velocity.Update(Vec3(x += 0.1, 0, 0), kVelocityDt_s);
  double v = 0;
  for (int i = 0; i < 2; ++i) v = velocity.Update(Vec3(x -= 0.1, 0, 0), kVelocityDt_s).x;
  EXPECT_NEAR(v, -100, 1e-6);
}

TEST(AdaptiveVelocity, AcceptsUnevenTicksAndInvalidInput) {
  AdaptiveVelocity velocity(1e-6);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> dt(0.0002, 0.004);
  double t = 0;
  Vec3 v{0};
  for (int i = 0; i < 200; ++i) {
    const double step = dt(random);
    t += step;
    v = velocity.Update(Vec3(5 * t, 0, 0), step);
  }
  EXPECT_NEAR(v.x, 5, 1e-3);
  EXPECT_EQ(velocity.Update(Vec3(std::nan(""), 0, 0), kVelocityDt_s).x, v.x);
  EXPECT_EQ(velocity.Update(Vec3(1e3, 0, 0), 0).x, v.x);
  EXPECT_EQ(velocity.Update(Vec3(1e3, 0, 0), -1).x, v.x);
  velocity.Reset();
  EXPECT_EQ(velocity.Update(Vec3(9, 9, 9), kVelocityDt_s), Vec3{0});
}

TEST(AdaptiveVelocity, HoldsTheVelocityOverRepeatedSamplesOnlyForAWhile) {
  AdaptiveVelocity velocity(0.001);
  double x = 0;
  Vec3 v{0};
  for (int i = 0; i < 50; ++i) v = velocity.Update(Vec3(x += 0.02, 0, 0), kVelocityDt_s);
  EXPECT_NEAR(v.x, 20, 1e-6);
  for (int i = 1; i <= 5; ++i) EXPECT_NEAR(velocity.Update(Vec3(x, 0, 0), kVelocityDt_s).x, 20, 1e-6) << i;
  for (int i = 6; i <= 100; ++i) EXPECT_EQ(velocity.Update(Vec3(x, 0, 0), kVelocityDt_s).x, 0) << i;
  x += 0.1;  // the jump to the new position is not a motion
  EXPECT_EQ(velocity.Update(Vec3(x, 0, 0), kVelocityDt_s).x, 0);
  EXPECT_NEAR(velocity.Update(Vec3(x += 0.02, 0, 0), kVelocityDt_s).x, 20, 1e-6);
}

TEST(AdaptiveVelocity, RepeatedSamplesOfASlowHandleAreNotAFault) {
  // At 4 mm/s in steps of 0.01 mm, three of five samples repeat the previous one, which is not a fault. The window of
  // 16 ms gives 4 mm/s to within one step per window.
  AdaptiveVelocity velocity(0.01);
  Vec3 v{0};
  for (int i = 0; i < 200; ++i) {
    v = velocity.Update(Vec3(0.01 * std::floor(0.4 * i), 0, 0), kVelocityDt_s);
    if (i > 20) {
      EXPECT_NEAR(v.x, 4, 0.01 / 0.015) << i;
    }
  }
}

TEST(AdaptiveVelocity, JumpGivesNoVelocity) {
  AdaptiveVelocity velocity(0.001);
  double x = 0;
  for (int i = 0; i < 50; ++i) velocity.Update(Vec3(x += 0.02, 0, 0), kVelocityDt_s);
  EXPECT_EQ(velocity.Update(Vec3(x += 5, 0, 0), kVelocityDt_s).x, 0);
  EXPECT_NEAR(velocity.Update(Vec3(x += 0.02, 0, 0), kVelocityDt_s).x, 20, 1e-6);
  // A change that a hand can cause counts as motion.
  for (int i = 1; i <= 3; ++i) EXPECT_GT(velocity.Update(Vec3(x += 0.02 + 0.25 * i, 0, 0), kVelocityDt_s).x, 200) << i;
}

}  // namespace
}  // namespace kerf
