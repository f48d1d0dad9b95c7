// Tests of the mapping from simulated force to device force, for any input.
#include "loop/haptics/force_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

#include "base/core/vectors.h"
#include "device/devices/profiles.h"
#include "kerf/error.h"
#include "loop/haptics/coupling_limits.h"
#include "support/message_of.h"

namespace kerf {
namespace {

const int kFixedSeed = setenv("RC_PARAMS", "seed=20261120", 0);
constexpr double kForceMapDt_s = 0.001;
constexpr double kMax = std::numeric_limits<double>::max();
constexpr double kDenormal = std::numeric_limits<double>::denorm_min();

/// Returns any bit pattern in half of the cases, otherwise an ordinary force.
double DrawAnything(std::mt19937_64& random) {
  switch (random() % 4) {
    case 0: {
      const std::uint64_t bits = random();
      double value = 0;
      std::memcpy(&value, &bits, sizeof value);
      return value;
    }
    case 1: {
      const double kSpecial[] = {0,     -0.0, kDenormal, -kDenormal,   kMax,
                                 -kMax, 1e30, 1e-30,     std::nan(""), std::numeric_limits<double>::infinity(),
                                 -1e300};
      return kSpecial[random() % std::size(kSpecial)];
    }
    default:
      return std::uniform_real_distribution<double>(-60, 60)(random);
  }
}

/// Returns the length with more digits than a double has.
long double CalcLongLength(const Vec3& v) {
  const long double x = v.x;
  const long double y = v.y;
  const long double z = v.z;
  return std::sqrt(x * x + y * y + z * z);
}

double CalcAngle(const Vec3& a, const Vec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

ForceMapParams AtOnce() {
  ForceMapParams params;
  params.ramp_in_s = 0;
  params.slew_N_per_s = 1e7;
  params.slew_Nmm_per_s = 1e9;
  return params;
}

TEST(LimitLength, IsNeverLongerThanTheLimitAndKeepsTheDirection) {
  const bool passed = rc::check([] {
    std::mt19937_64 random(*rc::gen::arbitrary<unsigned>());
    for (int i = 0; i < 200; ++i) {
      const Vec3 v(DrawAnything(random), DrawAnything(random), DrawAnything(random));
      const double limit = std::exp(std::uniform_real_distribution<double>(-20, 20)(random));
      const Vec3 limited = LimitLength(v, limit);
      RC_ASSERT(IsFinite(limited));
      RC_ASSERT(CalcLongLength(limited) <= static_cast<long double>(limit));
      RC_ASSERT(std::hypot(limited.x, limited.y, limited.z) <= limit);
      if (!IsFinite(v)) continue;
      const long double length = CalcLongLength(v);
      // The vector is unchanged if it is shorter than the limit by more than rounding; otherwise it has the limit's
      // length.
      if (length < 0.999999L * static_cast<long double>(limit)) RC_ASSERT(limited == v);
      RC_ASSERT(CalcLongLength(limited) >= std::min(length, static_cast<long double>(limit)) * 0.99999999L);
      if (std::abs(v.x) < 1e150 && std::abs(v.y) < 1e150 && std::abs(v.z) < 1e150 && length > 1e-150L) {
        RC_ASSERT(CalcAngle(v / static_cast<double>(length), limited / static_cast<double>(CalcLongLength(limited))) <
                  1e-7);
      }
    }
  });
  EXPECT_TRUE(passed);
}

TEST(ForceMap, NeverExceedsTheDevicesPeakForAnyInput) {
  const bool passed = rc::check([] {
    std::mt19937_64 random(*rc::gen::arbitrary<unsigned>());
    const DeviceProfile& profile = *rc::gen::elementOf(DeviceProfiles());
    ForceMapParams params;
    params.knee = std::uniform_real_distribution<double>(0.1, 1)(random);
    params.ramp_in_s = *rc::gen::element(0.0, 0.5);
    params.slew_N_per_s = *rc::gen::element(0.0, 1.0, 1e7);
    params.thermal_s = *rc::gen::element(0.1, 10.0);
    params.expected_peak_N = *rc::gen::element(0.1, 28.0, 1e4);
    ForceMap map(profile, params);
    for (int i = 0; i < 300; ++i) {
      const Vec3 f(DrawAnything(random), DrawAnything(random), DrawAnything(random));
      const Vec3 tau(DrawAnything(random), DrawAnything(random), DrawAnything(random));
      const double dt = random() % 8 == 0 ? DrawAnything(random) : kForceMapDt_s;
      const bool fault = random() % 32 == 0;
      const ForceMapOutput out = map.Calc(f, tau, dt, fault);
      RC_ASSERT(IsFinite(out.f_H_W_N) && IsFinite(out.tau_H_W_Nmm));
      RC_ASSERT(CalcLongLength(out.f_H_W_N) <= static_cast<long double>(profile.peak_force_N));
      RC_ASSERT(CalcLongLength(out.tau_H_W_Nmm) <= static_cast<long double>(profile.peak_torque_Nmm));
      RC_ASSERT(out.thermal_load <= 1 + 1e-12);
      if (fault || !IsFinite(f) || !IsFinite(tau) || !(dt >= 0) || !std::isfinite(dt)) {
        RC_ASSERT(out.f_H_W_N == Vec3{0} && out.tau_H_W_Nmm == Vec3{0});
        RC_ASSERT((out.status & (kForceMapFault | kForceMapNotFinite)) != 0u);
      }
    }
  });
  EXPECT_TRUE(passed);
}

TEST(ForceMap, ScalesTheExpectedPeakToTheDevicesPeak) {
  // For the omega.3 the factor is 12 / 28. Well below the knee, the map is exactly this factor, except for rounding.
  ForceMap map(FindDeviceProfile("omega_3"), AtOnce());
  EXPECT_DOUBLE_EQ(map.force_scale(), 12.0 / 28);
  const ForceMapOutput out = map.Calc(Vec3(7, -14, 0.5), Vec3(100, 0, 0), kForceMapDt_s);
  EXPECT_DOUBLE_EQ(out.f_H_W_N.x, 3);
  EXPECT_DOUBLE_EQ(out.f_H_W_N.y, -6);
  EXPECT_EQ(out.tau_H_W_Nmm, Vec3{0});  // the device does not output torque
  EXPECT_EQ(out.status, kForceMapOk);
  // A device that is stronger than expected does not output more than the simulated force.
  EXPECT_EQ(ForceMap(FindDeviceProfile("maglev_200")).force_scale(), 1);
  EXPECT_DOUBLE_EQ(ForceMap(FindDeviceProfile("sigma_7")).torque_scale(), 0.5);
}

TEST(ForceMap, SaturatesSmoothlyAndKeepsTheDirection) {
  const DeviceProfile& profile =
      FindDeviceProfile("delta_3");  // 20 N; the continuous force is as large, so the motors do not heat up
  const Vec3 direction = glm::normalize(Vec3(1, 2, -3));
  double before = 0;
  double slope_before = 1;
  for (double f = 0.05; f < 400; f += 0.05) {
    ForceMap map(profile, AtOnce());
    const Vec3 out = map.Calc(f * 28 / 20 * direction, Vec3{0}, kForceMapDt_s).f_H_W_N;
    const double length = glm::length(out);
    EXPECT_LT(CalcAngle(out, direction), 1e-7);
    EXPECT_LT(length, 20);
    const double slope = (length - before) / 0.05;
    EXPECT_GT(slope, 0) << f;
    EXPECT_LE(slope, 1 + 1e-9) << f;
    // The curve has no corner: its largest curvature is 2 / (peak - knee) = 1 per N, just past the knee.
    EXPECT_LT(std::abs(slope - slope_before), 1.05 * 0.05) << f;
    if (f < 18) {
      EXPECT_NEAR(length, f, 1e-12);
    }
    before = length;
    slope_before = slope;
  }
  EXPECT_GT(before, 19.9);
}

TEST(ForceMap, LimitsTheSlewRateOfTheForceVector) {
  // By default, the force may rise from 0 to the peak in 5 ms: 12 N / 5 ms.
  ForceMapParams params;
  params.ramp_in_s = 0;
  ForceMap map(FindDeviceProfile("omega_3"), params);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> draw(-100, 100);
  Vec3 before{0};
  for (int i = 0; i < 2000; ++i) {
    const ForceMapOutput out = map.Calc(Vec3(draw(random), draw(random), draw(random)), Vec3{0}, kForceMapDt_s);
    EXPECT_LE(glm::length(out.f_H_W_N - before), 2.4 * (1 + 1e-12));
    before = out.f_H_W_N;
  }
  EXPECT_GT(map.counts().slew_limited, 1000u);
  // The force reaches its target, 10 N on the device, after 5 ticks.
  map.Reset();
  ForceMapOutput out;
  for (int i = 0; i < 5; ++i) out = map.Calc(Vec3(0, 10 * 28 / 12.0, 0), Vec3{0}, kForceMapDt_s);
  EXPECT_NEAR(out.f_H_W_N.y, 10, 1e-12);
}

TEST(ForceMap, LimitsTheSlewRateOfTheTorque) {
  // As for the force, the torque may rise from 0 to the peak in 5 ms, or as requested.
  const DeviceProfile& profile = FindDeviceProfile("virtuose_6d");
  ASSERT_GT(profile.peak_torque_Nmm, 0);
  for (const double asked : {0.0, 5000.0}) {
    ForceMapParams params;
    params.ramp_in_s = 0;
    params.slew_Nmm_per_s = asked;
    const double most = asked > 0 ? 5 : profile.peak_torque_Nmm / 5;
    ForceMap map(profile, params);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> draw(-1e4, 1e4);
    Vec3 before{0};
    double fastest = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec3 tau = map.Calc(Vec3{0}, Vec3(draw(random), draw(random), draw(random)), kForceMapDt_s).tau_H_W_Nmm;
      EXPECT_LE(glm::length(tau - before), most * (1 + 1e-12));
      fastest = std::max(fastest, glm::length(tau - before));
      before = tau;
    }
    EXPECT_GT(fastest, 0.999 * most);
  }
}

TEST(ForceMap, FaultGivesZeroForceAtOnceAndThenARamp) {
  ForceMapParams params;
  ForceMap map(FindDeviceProfile("delta_3"), params);
  const Vec3 f(0, 0, 14);  // 10 N on the device
  double before = 0;
  for (int i = 0; i < 1000; ++i) {
    const ForceMapOutput out = map.Calc(f, Vec3{0}, kForceMapDt_s);
    EXPECT_GE(out.f_H_W_N.z, before);
    // The ramp 3t^2 - 2t^3 over 0.5 s has a slope of at most 1.5 / 0.5 s.
    EXPECT_LE(out.f_H_W_N.z - before, 10 * 3 * kForceMapDt_s * (1 + 1e-9));
    EXPECT_EQ((out.status & kForceMapRampIn) != 0, i < 499) << i;
    before = out.f_H_W_N.z;
  }
  EXPECT_NEAR(before, 10, 1e-12);
  for (const bool reported : {true, false}) {
    const ForceMapOutput fault = map.Calc(reported ? f : Vec3(std::nan(""), 0, 0), Vec3{0}, kForceMapDt_s, reported);
    EXPECT_EQ(fault.f_H_W_N, Vec3{0});
    EXPECT_EQ(fault.status, reported ? kForceMapFault : kForceMapNotFinite);
    const ForceMapOutput after = map.Calc(f, Vec3{0}, kForceMapDt_s);
    EXPECT_LT(after.f_H_W_N.z, 1e-3);  // 10 N * 3 (1/500)^2 = 0.12 mN
    EXPECT_GT(after.f_H_W_N.z, 0);
    for (int i = 0; i < 600; ++i) map.Calc(f, Vec3{0}, kForceMapDt_s);
  }
  EXPECT_EQ(map.counts().faults, 2u);
}

TEST(ForceMap, LongPushFallsToTheContinuousForce) {
  // The Omni has a peak force of 3.3 N and a continuous force of 0.88 N. The load never exceeds 1, and the force
  // settles at the continuous value.
  const DeviceProfile& omni = FindDeviceProfile("omni");
  ForceMap map(omni, AtOnce());
  double warm = 0;
  double before = 3.3;
  int first_limited = -1;
  for (int i = 0; i < 60000; ++i) {
    const ForceMapOutput out = map.Calc(Vec3(0, 0, 1000), Vec3{0}, kForceMapDt_s);
    const double f = out.f_H_W_N.z;
    warm += (1 - std::exp(-kForceMapDt_s / 10)) * (f * f - warm);  // computed independently by the test
    ASSERT_LE(std::sqrt(warm), 0.88 * (1 + 1e-9)) << i;
    ASSERT_LE(f, before + 1e-12) << i;
    ASSERT_GE(f, before - 0.01) << i;  // the force falls gradually
    if (first_limited < 0 && (out.status & kForceMapThermalLimited) != 0) first_limited = i;
    before = f;
  }
  EXPECT_NEAR(before, 0.88, 0.01);
  // A load of 0.7 is reached at 10 s * -ln(1 - 0.7 (0.88/3.3)^2) = 0.511 s.
  EXPECT_NEAR(first_limited, 511, 5);
  EXPECT_GT(map.counts().thermal_limited, 50000u);
  // After half a minute of rest the peak is available again.
  for (int i = 0; i < 30000; ++i) map.Calc(Vec3{0}, Vec3{0}, kForceMapDt_s);
  EXPECT_GT(map.Calc(Vec3(0, 0, 1000), Vec3{0}, kForceMapDt_s).f_H_W_N.z, 3.2);
}

TEST(ForceMap, BadParametersAreNamed) {
  const auto message = [](ForceMapParams params) -> std::string {
    return test::MessageOf([&] { ForceMap(FindDeviceProfile("omni"), params); });
  };
  EXPECT_EQ(message({.expected_peak_N = 0}), "expected_peak_N = 0 is below 0.1; valid range 0.1 to 10000 N");
  EXPECT_EQ(message({.knee = 1.1}), "knee = 1.1 is above 1; valid range 0.1 to 1");
  EXPECT_EQ(message({.slew_N_per_s = -5}), "slew_N_per_s = -5 is below 1; valid range 1 to 10000000 N/s, or 0");
  EXPECT_EQ(message({.ramp_in_s = std::nan("")}), "ramp_s = nan is not a finite number; valid range 0 to 60 s");
}

TEST(CouplingLimits, AreTheDevicesLimitsDividedByTheForceScale) {
  const DeviceProfile& omni = FindDeviceProfile("omni");
  const double scale = 3.3 / 28;
  CouplingParams coupling;
  coupling.stiffness_N_per_mm = 10;
  coupling.damping_Ns_per_mm = 0.001;
  const CouplingLimits limits = CalcCouplingLimits(omni, FindHandModel("H2"), coupling, scale, 0, 0.001, 1);
  EXPECT_NEAR(limits.stiffness_N_per_mm, 0.7 / scale, 1e-12);
  EXPECT_NEAR(limits.damping_Ns_per_mm, 0.005 / scale, 1e-12);
  // The limit is s K < 2 b / (T + 2 t_d), whatever the coupling's own damping is.
  EXPECT_NEAR(limits.sampled_stiffness_N_per_mm * scale, 2 * (0.0001 + 0.003) / 0.003, 1e-12);
  EXPECT_NEAR(limits.quantum_stiffness_N_per_mm * scale, 2 * 0.26 / 0.055, 1e-12);
  EXPECT_NEAR(limits.step_N, 0.55, 1e-12);
  bool changed = false;
  const CouplingParams lowered = LimitCoupling(coupling, limits, &changed);
  EXPECT_TRUE(changed);
  EXPECT_EQ(lowered.stiffness_N_per_mm, limits.stiffness_N_per_mm);
  EXPECT_EQ(lowered.damping_Ns_per_mm, 0.001);
  EXPECT_EQ(lowered.torsion_Nmm_per_rad, coupling.torsion_Nmm_per_rad);  // without torque there is no limit
  LimitCoupling(lowered, limits, &changed);
  EXPECT_FALSE(changed);
}

TEST(FitCoupling, StaysBelowAFractionOfTheSampledLoopsLimit) {
  // For omega_6 with H1 at 250 Hz, the device allows 5 N/mm and the loop 2 (0.001 + 0.001) / 0.004 = 1 N/mm, both at
  // the device.
  const DeviceProfile& omega = FindDeviceProfile("omega_6");
  const double scale = 12.0 / 28;
  CouplingParams coupling;
  coupling.stiffness_N_per_mm = 100;
  const FittedCoupling fitted = FitCoupling(omega, FindHandModel("H1"), coupling, scale, 0, 0.004);
  EXPECT_NEAR(fitted.coupling.stiffness_N_per_mm * scale, kSampledFraction * 1, 1e-12);
  EXPECT_NEAR(fitted.limits.sampled_stiffness_N_per_mm * scale, 1, 1e-12);
  EXPECT_TRUE(fitted.lowered.by_device);
  EXPECT_TRUE(fitted.lowered.by_loop);
  // With a firm grip at 1 kHz, the loop allows 32 N/mm, so the device's 5 N/mm are the limit.
  const FittedCoupling firm = FitCoupling(omega, FindHandModel("H4"), coupling, scale, 0, 0.001);
  EXPECT_NEAR(firm.coupling.stiffness_N_per_mm * scale, 5, 1e-12);
  EXPECT_FALSE(firm.lowered.by_loop);
  coupling.stiffness_N_per_mm = 1;
  const FittedCoupling soft = FitCoupling(omega, FindHandModel("H3"), coupling, scale, 0, 0.001);
  EXPECT_EQ(soft.coupling.stiffness_N_per_mm, 1);
  EXPECT_FALSE(soft.lowered.any());
  // The coupling's own damping does not raise the limit of its stiffness, because damping computed from an encoder's
  // velocity is delayed.
  coupling.stiffness_N_per_mm = 100;
  coupling.damping_Ns_per_mm = 0.01;
  EXPECT_NEAR(FitCoupling(omega, FindHandModel("H1"), coupling, scale, 0, 0.004).coupling.stiffness_N_per_mm * scale,
              kSampledFraction * 1, 1e-12);
  coupling = {};
  // H1 damps rotation with 5 N mm s, so that the loop of a device that outputs torques allows 10000 N mm/rad at 1 kHz.
  EXPECT_EQ(soft.limits.sampled_torsion_Nmm_per_rad, std::numeric_limits<double>::infinity());
  const FittedCoupling turned =
      FitCoupling(FindDeviceProfile("virtuose_6d"), FindHandModel("H1"), coupling, 1, 0.5, 0.001);
  EXPECT_NEAR(turned.limits.sampled_torsion_Nmm_per_rad, 10000 / 0.5, 1e-9);
  EXPECT_EQ(turned.coupling.torsion_Nmm_per_rad, 5000);
  coupling.torsion_Nmm_per_rad = 7000;
  const FittedCoupling stiff =
      FitCoupling(FindDeviceProfile("virtuose_6d"), FindHandModel("H1"), coupling, 1, 0.5, 0.001);
  EXPECT_NEAR(stiff.coupling.torsion_Nmm_per_rad, kSampledFraction * 10000 / 0.5, 1e-9);
  EXPECT_TRUE(stiff.lowered.torsion_by_loop);
  EXPECT_FALSE(stiff.lowered.by_loop);
  // The rotation of a released device is not known.
  EXPECT_EQ(FitCoupling(FindDeviceProfile("virtuose_6d"), FindHandModel("H0"), coupling, 1, 0.5, 0.001)
                .coupling.torsion_Nmm_per_rad,
            7000);
}

// The limit is 0.8 m / (t (1 + 2 (K + k) t^2 / m)), where t is the delay: a velocity from 16 samples is 7.5 ticks late,
// and holding the force adds half a tick.
TEST(FitCoupling, LimitsDampingForADelayedVelocity) {
  const DeviceProfile& omega = FindDeviceProfile("omega_6");
  const double scale = 12.0 / 28;
  CouplingParams coupling;
  coupling.stiffness_N_per_mm = 0.3;
  coupling.damping_Ns_per_mm = 0.045;
  const double m = 0.27e-3;
  const double late_s = 8 * 0.002;
  const double most = 0.8 * m / (late_s * (1 + 2 * (0.3 * scale + 0.1) * late_s * late_s / m));
  const FittedCoupling fitted = FitCoupling(omega, FindHandModel("H1"), coupling, scale, 0, 0.002);
  EXPECT_NEAR(fitted.coupling.damping_Ns_per_mm * scale, most, 1e-12);
  EXPECT_TRUE(fitted.lowered.damping_by_loop);
  EXPECT_EQ(fitted.coupling.stiffness_N_per_mm, 0.3);
  // An arm is heavier and tolerates this damping. The coupling's damping does not raise the loop's stiffness limit
  // either.
  const FittedCoupling arm = FitCoupling(omega, FindHandModel("H3"), coupling, scale, 0, 0.002);
  EXPECT_EQ(arm.coupling.damping_Ns_per_mm, 0.045);
  EXPECT_FALSE(arm.lowered.any());
  EXPECT_NEAR(arm.limits.sampled_stiffness_N_per_mm * scale, 2 * (0.001 + 0.00645) / 0.002, 1e-9);
}

TEST(FitCoupling, AddsTheDampingThatASampledSpringNeeds) {
  CouplingParams coupling;
  coupling.stiffness_N_per_mm = 2;
  const DeviceProfile& omega = FindDeviceProfile("omega_6");
  const HandModel& hand = FindHandModel("H3");
  const double scale = 12.0 / 28;
  const FittedCoupling fitted = FitCoupling(omega, hand, coupling, scale, 0, 0.001);
  EXPECT_NEAR(fitted.coupling.damping_Ns_per_mm, 1.5 * 2 * 0.001 / 2, 1e-15);
  EXPECT_NEAR(FitCoupling(omega, hand, coupling, scale, 0, 0.002).coupling.damping_Ns_per_mm, 1.5 * 2 * 0.002 / 2,
              1e-15);
  // The added damping does not raise the loop's stiffness limit.
  EXPECT_NEAR(fitted.limits.sampled_stiffness_N_per_mm * scale, 2 * (0.001 + 0.00645) / 0.001, 1e-9);
  // Damping that is already larger is kept, but it never exceeds the device's limit.
  coupling.damping_Ns_per_mm = 0.01;
  EXPECT_EQ(FitCoupling(omega, hand, coupling, scale, 0, 0.001).coupling.damping_Ns_per_mm, 0.01);
  DeviceProfile weak = omega;
  weak.max_damping_Ns_per_mm = 0.0005;
  coupling.damping_Ns_per_mm = 0;
  EXPECT_NEAR(FitCoupling(weak, hand, coupling, scale, 0, 0.001).coupling.damping_Ns_per_mm * scale, 0.0005, 1e-15);
}

}  // namespace
}  // namespace kerf
