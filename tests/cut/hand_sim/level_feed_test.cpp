// A hand-held saw is moved level through a kerf, with laws that are nonzero at the smallest bite. The teeth's thrust is
// compared with the integral over the arc that moves outwards, for any position of the rim's samples.
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "kerf/coupled.h"
#include "support/cuts.h"
#include "support/saw.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using test::DiscPose;

constexpr double kTop_mm = 4;
constexpr double kPasses_per_s = 24 * 125;
constexpr double kRamp_mm_per_s = 0.02;  // speed at which a step's ramp reaches its full force (docs/tick.md)

/// Returns the thrust of Z / (2 pi) teeth per radian, from where the rim stops moving outwards to where it leaves the
/// surface.
double CalcThrust(const ToothForce& force, double E_star_MPa, const Vec3& centre, const Vec3& v) {
  const double alpha = std::acos((centre.z - kTop_mm) / kR);
  const double lowest = std::atan2(v.z, v.x);  // angle from straight down, where e = (sin, 0, -cos), at which v . e = 0
  constexpr int kIntervals = 2000;
  double thrust = 0;
  for (int i = 0; i < kIntervals; ++i) {
    const double phi = lowest + (alpha - lowest) * (i + 0.5) / kIntervals;
    const double speed = v.x * std::sin(phi) - v.z * std::cos(phi);
    if (!(speed > 0)) continue;
    thrust += force(speed / kPasses_per_s, Cortical(E_star_MPa)) * std::min(1.0, speed / kRamp_mm_per_s) * kSaw.teeth /
              (2 * std::numbers::pi) * (alpha - lowest) / kIntervals;
  }
  return thrust;
}

struct Level {
  double mean = 0;     // thrust relative to the closed form
  double largest = 0;  // largest step from tick to tick
};

Level MeasureLevel(const Bone& block, const ForceLaw& law, int samples, double turn_rad) {
  CoupledParams params;
  params.law = law;
  params.rim_samples_per_pitch = samples;
  params.effects.clear();
  params.coupling.stiffness_N_per_mm = 1000;
  params.coupling.torsion_Nmm_per_rad = 1e7;
  params.coupling.max_force_N = 1e4;
  params.coupling.max_torque_Nmm = 1e6;
  const double z = kTop_mm - 1.1 + kR;
  const Quat turn = glm::angleAxis(turn_rad, Vec3(0, 0, 1));
  const auto pose = [&](double x) {
    Pose X = DiscPose(Pose{}, {x, 0, z});
    X.R_AB = X.R_AB * turn;
    return X;
  };
  CoupledSimulation simulation(block, params, pose(-14));
  CoupledInput in;
  for (double x = -13.98; x < -3; x += 0.02) {
    in.X_WH = pose(x);
    simulation.Tick(in);
  }
  const ToothForce force = MakeToothForce(law, kSaw);
  const double E_star = CalcReducedModulus(kSaw.E_MPa, kSaw.nu, 19300, 0.28);
  Level level;
  constexpr int kTicks = 400;
  Vec3 before(0);
  double last = 0;
  for (int i = 1; i <= kTicks; ++i) {
    in.X_WH = pose(-3 + 0.004 * i);
    const CoupledOutput out = simulation.Tick(in);
    const double by_form = out.thrust_sum_N / CalcThrust(force, E_star, before, (out.X_WT.p_AB - before) * 1e3);
    if (i > kTicks / 2) {
      level.mean += by_form / (kTicks / 2);
      level.largest = std::max(level.largest, std::abs(by_form - last));
    }
    last = by_form;
    before = out.X_WT.p_AB;
  }
  return level;
}

TEST(CoupledLevelFeed, ThrustMatchesTheIntegralForAnySamplePositions) {
  Bone bone = test::MakeBox(Pose{}, {24, 1.5, 8}, 0.1);
  bone.set_materials(test::OneRegionTable(24, 19300, 0.28));
  for (const char* name : {"hertz_constant_bite", "edge_plus_chip"}) {
    for (const int samples : {16, 4}) {
      for (const double fraction : {0.0, 0.25, 0.5}) {
        const Level level =
            MeasureLevel(bone, ForceLaw(name), samples, fraction * 2 * std::numbers::pi / (kSaw.teeth * samples));
        std::printf("%s, %d samples a pitch, turned %.2f: mean %+.2f %%, largest step %.2f %%\n", name, samples,
                    fraction, 100 * (level.mean - 1), 100 * level.largest);
        // If the force is taken at each sample alone, the means are off by up to 1.3 % with 16 samples and by up to
        // 6.8 % with 4 samples. The tolerances are those of a tool on a path
        // (tests/cut/path_sim/level_feed_test.cpp).
        EXPECT_NEAR(level.mean, 1, samples == 16 ? 0.001 : 0.006) << name << ", " << samples << ", turned " << fraction;
        EXPECT_LT(level.largest, 0.004) << name << ", " << samples << " samples, turned " << fraction;
      }
    }
  }
}

}  // namespace
}  // namespace kerf
