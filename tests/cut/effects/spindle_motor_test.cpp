// The motor alone: run-up and run-down against analytic curves, steady speeds, stall, and the energy balance.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "cut/effects/spindle/motor.h"

namespace kerf {
namespace {

Motor HandMotor() {
  Motor m;
  m.stall_torque_Nmm = 300;
  m.no_load_rad_per_s = 800;
  m.inertia_gmm2 = 1000;
  m.friction_Nmm = 5;
  m.viscous_Nmms = 0.005;
  return m;
}

/// Runs the motor for the given time in several intervals.
MotorRun RunInPieces(const Motor& m, double set, double load, double hold, double w, double time_s, int pieces) {
  MotorRun sum;
  sum.w_rad_per_s = w;
  for (int i = 0; i < pieces; ++i) {
    const MotorRun run = RunMotor(m, set, load, hold, sum.w_rad_per_s, time_s / pieces);
    sum.w_rad_per_s = run.w_rad_per_s;
    sum.angle_rad += run.angle_rad;
    sum.motor_mJ += run.motor_mJ;
    sum.load_mJ += run.load_mJ;
    sum.friction_mJ += run.friction_mJ;
    sum.viscous_mJ += run.viscous_mJ;
  }
  return sum;
}

void ExpectNear(const MotorRun& a, const MotorRun& b, double fraction) {
  const double mJ = fraction * (1 + std::abs(b.motor_mJ) + b.load_mJ + b.friction_mJ + b.viscous_mJ);
  EXPECT_NEAR(a.w_rad_per_s, b.w_rad_per_s, fraction * (1 + std::abs(b.w_rad_per_s)));
  EXPECT_NEAR(a.angle_rad, b.angle_rad, fraction * (1 + std::abs(b.angle_rad)));
  EXPECT_NEAR(a.motor_mJ, b.motor_mJ, mJ);
  EXPECT_NEAR(a.load_mJ, b.load_mJ, mJ);
  EXPECT_NEAR(a.friction_mJ, b.friction_mJ, mJ);
  EXPECT_NEAR(a.viscous_mJ, b.viscous_mJ, mJ);
}

TEST(SpindleMotor, RunUpFollowsTheAnalyticCurveForAnyTick) {
  const Motor m = HandMotor();
  const double k = m.stall_torque_Nmm / m.no_load_rad_per_s;
  const double set = 785, load = 80;
  const double steady = (k * set - m.friction_Nmm - load) / (k + m.viscous_Nmms);
  const double tau_s = m.CalcInertia() / (k + m.viscous_Nmms);
  for (const double dt_s : {1e-6, 1e-5, 2.5e-4, 1e-3, 4e-3, 0.1, 1.0}) {
    double w = 0, angle = 0, t_s = 0;
    for (int i = 0; i < 2000 && t_s < 20 * tau_s; ++i) {
      const MotorRun run = RunMotor(m, set, load, 0, w, dt_s);
      w = run.w_rad_per_s;
      angle += run.angle_rad;
      t_s += dt_s;
      // 1e-11 allows for two thousand rounding errors.
      ASSERT_NEAR(w, steady * -std::expm1(-t_s / tau_s), 1e-11 * steady) << dt_s;
      ASSERT_NEAR(angle, steady * (t_s + tau_s * std::expm1(-t_s / tau_s)), 1e-11 * (1 + steady * t_s)) << dt_s;
    }
  }
}

TEST(SpindleMotor, RunDownFollowsTheAnalyticCurveAndEndsAtRest) {
  Motor m = HandMotor();
  m.brakes = false;
  // w = (w0 + f/b) exp(-b t / J) - f/b, and it is at rest after J/b ln(1 + w0 b / f).
  const double w0 = 785, f_b = m.friction_Nmm / m.viscous_Nmms, tau_s = m.CalcInertia() / m.viscous_Nmms;
  const double rest_s = tau_s * std::log1p(w0 / f_b);
  const double angle = tau_s * (w0 - f_b * std::log1p(w0 / f_b));
  for (const double dt_s : {1e-4, 1e-3, 0.01, 1.0}) {
    double w = w0, turned = 0, t_s = 0;
    while (t_s < 1.2 * rest_s) {
      const MotorRun run = RunMotor(m, 0, 0, 0, w, dt_s);
      w = run.w_rad_per_s;
      turned += run.angle_rad;
      t_s += dt_s;
      EXPECT_EQ(run.motor_mJ, 0);
      const double expected = t_s < rest_s ? w0 * std::exp(-t_s / tau_s) + f_b * std::expm1(-t_s / tau_s) : 0;
      ASSERT_NEAR(w, expected, 1e-10 * w0) << dt_s << " " << t_s;
    }
    EXPECT_EQ(w, 0);
    EXPECT_NEAR(turned, angle, 1e-10 * angle);
  }
  // Without viscous loss the curve is a straight line.
  m.viscous_Nmms = 0;
  EXPECT_NEAR(RunMotor(m, 0, 0, 0, w0, 0.1).w_rad_per_s, w0 - m.friction_Nmm / m.CalcInertia() * 0.1, 1e-12 * w0);
  const MotorRun run = RunMotor(m, 0, 0, 0, w0, 1);
  EXPECT_EQ(run.w_rad_per_s, 0);
  EXPECT_NEAR(run.angle_rad, 0.5 * w0 * w0 * m.CalcInertia() / m.friction_Nmm, 1e-12 * run.angle_rad);
}

TEST(SpindleMotor, BrakingIsFasterThanCoasting) {
  Motor m = HandMotor();
  const double k = m.stall_torque_Nmm / m.no_load_rad_per_s;
  // The decelerating torque is (k + b) w + f: w = (w0 + f/B) exp(-B t / J) - f/B.
  const double B = k + m.viscous_Nmms, w0 = 785, t_s = 1e-3;
  EXPECT_NEAR(RunMotor(m, 0, 0, 0, w0, t_s).w_rad_per_s,
              (w0 + m.friction_Nmm / B) * std::exp(-B * t_s / m.CalcInertia()) - m.friction_Nmm / B, 1e-12 * w0);
  // With reversed voltage it brakes with at most the stall torque.
  const double from = 600;
  m.viscous_Nmms = 0;
  EXPECT_NEAR(RunMotor(m, -800, 0, 0, from, 1e-3).w_rad_per_s,
              from - (m.stall_torque_Nmm + m.friction_Nmm) / m.CalcInertia() * 1e-3, 1e-12 * from);
}

TEST(SpindleMotor, SteadySpeedLiesOnTheLineUnderAnyLoad) {
  Motor m = HandMotor();
  m.friction_Nmm = m.viscous_Nmms = 0;
  for (const double load : {0.0, 30.0, 150.0, 290.0, 299.0}) {
    const MotorRun run = RunMotor(m, 800, load, 0, 800, 1);
    EXPECT_NEAR(run.w_rad_per_s, 800 * (1 - load / 300), 1e-9 * 800) << load;
    EXPECT_NEAR(m.CalcTorque(800, run.w_rad_per_s), load, 1e-9 * 300);
  }
  // At the stall torque it does not turn; slightly below, it does.
  EXPECT_EQ(RunMotor(m, 800, 301, 0, 800, 1).w_rad_per_s, 0);
  EXPECT_EQ(RunMotor(m, 800, 300, 0, 0, 1).w_rad_per_s, 0);
  EXPECT_GT(RunMotor(m, 800, 299.999, 0, 0, 1).w_rad_per_s, 0);
}

TEST(SpindleMotor, HoldTorqueMattersOnlyAtRest) {
  const Motor m = HandMotor();
  EXPECT_EQ(RunMotor(m, 800, 0, 295.1, 0, 1).w_rad_per_s, 0);
  const MotorRun starts = RunMotor(m, 800, 0, 294.9, 0, 1);
  EXPECT_GT(starts.w_rad_per_s, 700);
  EXPECT_EQ(starts.load_mJ, 0);
  ExpectNear(RunMotor(m, 800, 50, 1e6, 300, 0.01), RunMotor(m, 800, 50, 0, 300, 0.01), 0);
}

TEST(SpindleMotor, RandomRunsBalanceEnergyAndDoNotDependOnTheTick) {
  std::mt19937_64 random(7);
  const auto uniform = [&](double lower, double upper) {
    return std::uniform_real_distribution<double>(lower, upper)(random);
  };
  int stopped = 0, reversed = 0;
  for (int i = 0; i < 20000; ++i) {
    Motor m;
    m.stall_torque_Nmm = std::exp(uniform(0, 7));
    m.no_load_rad_per_s = std::exp(uniform(2, 9));
    m.inertia_gmm2 = std::exp(uniform(3, 12));
    m.friction_Nmm = random() % 3 == 0 ? 0 : m.stall_torque_Nmm * uniform(0, 0.3);
    m.viscous_Nmms = random() % 3 == 0 ? 0 : m.stall_torque_Nmm / m.no_load_rad_per_s * std::exp(uniform(-20, 0));
    m.brakes = random() % 2 == 0;
    const double set = random() % 5 == 0 ? 0 : m.no_load_rad_per_s * uniform(-1, 1);
    const double load = random() % 3 == 0 ? 0 : m.stall_torque_Nmm * uniform(0, 1.5);
    const double w0 = random() % 5 == 0 ? 0 : m.no_load_rad_per_s * uniform(-3, 3);
    const double time_s = std::exp(uniform(-12, 0));
    SCOPED_TRACE(i);
    const MotorRun run = RunMotor(m, set, load, 0, w0, time_s);
    ASSERT_TRUE(std::isfinite(run.w_rad_per_s));
    ASSERT_GE(run.load_mJ, 0);
    ASSERT_GE(run.friction_mJ, 0);
    ASSERT_GE(run.viscous_mJ, 0);
    const double gained = 0.5 * m.CalcInertia() * (run.w_rad_per_s * run.w_rad_per_s - w0 * w0);
    const double largest =
        std::abs(run.motor_mJ) + run.load_mJ + run.friction_mJ + run.viscous_mJ + 0.5 * m.CalcInertia() * w0 * w0;
    ASSERT_NEAR(run.motor_mJ - run.load_mJ - run.friction_mJ - run.viscous_mJ, gained, 1e-9 * largest);
    // A motor that is slowed only by viscous loss never stops, except through rounding.
    const bool creeps = !m.brakes && m.friction_Nmm + load == 0 && set * w0 <= 0;
    if (!creeps) ExpectNear(RunInPieces(m, set, load, 0, w0, time_s, 37), run, 1e-9);
    // The run with all signs reversed must be the exact mirror image.
    const MotorRun mirrored = RunMotor(m, -set, load, 0, -w0, time_s);
    ASSERT_EQ(mirrored.w_rad_per_s, -run.w_rad_per_s);
    ASSERT_EQ(mirrored.angle_rad, -run.angle_rad);
    ASSERT_EQ(mirrored.motor_mJ, run.motor_mJ);
    if (testing::Test::HasFailure()) FAIL() << set << " " << load << " " << w0 << " " << time_s;
    stopped += run.w_rad_per_s == 0;
    reversed += run.w_rad_per_s * w0 < 0;
  }
  EXPECT_GT(stopped, 1000);
  EXPECT_GT(reversed, 200);
}

TEST(SpindleMotor, AgreesWithAFineIntegrationOfItsEquation) {
  // An independent method for comparison: the midpoint rule on J w' = T(w) - (f + load) sign w - b w, in steps of 1e-7
  // s, with a reversal.
  for (const bool brakes : {true, false}) {
    Motor m = HandMotor();
    m.brakes = brakes;
    m.inertia_gmm2 = 300;
    const double set = -500, load = 40, w0 = 900, h = 1e-7;
    const auto rate = [&](double w) {
      return (m.CalcTorque(set, w) - (m.friction_Nmm + load) * (w > 0 ? 1 : -1) - m.viscous_Nmms * w) / m.CalcInertia();
    };
    double w = w0;
    for (int i = 0; i < 100000; ++i) {
      w += h * rate(w + 0.5 * h * rate(w));
      if (i % 20000 == 19999) {
        // The time of each corner of the curve has an error of up to 1e-7 s, at an acceleration of up to 2e6 rad/s^2.
        EXPECT_NEAR(RunMotor(m, set, load, 0, w0, (i + 1) * h).w_rad_per_s, w, 0.3) << i;
      }
    }
    EXPECT_LT(w, -100);
  }
}

}  // namespace
}  // namespace kerf
