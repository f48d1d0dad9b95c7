// The simulated device and its hand, compared with closed forms, and faults of a device.
#include "device/devices/simulated_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "device/devices/profiles.h"
#include "kerf/error.h"
#include "support/message_of.h"

namespace kerf {
namespace {

constexpr double kSimulatedDeviceDt_s = 0.001;

DeviceProfile MakePlain(double mass_kg = 0.2) {
  DeviceProfile profile = FindDeviceProfile("ideal");
  profile.mass_kg = mass_kg;
  profile.own_damping_Ns_per_mm = 0;
  return profile;
}

HandModel MakeHand(double m, double b, double k) {
  HandModel hand;
  hand.mass_kg = m;
  hand.damping_Ns_per_mm = b;
  hand.stiffness_N_per_mm = k;
  return hand;
}

Pose PoseAt(double x, double y = 0, double z = 0) {
  return {Quat{1, 0, 0, 0}, Vec3(x, y, z)};
}

SimulatedDeviceOptions Fine(int substeps = 20) {
  SimulatedDeviceOptions options;
  options.substeps = substeps;
  options.quantise = false;
  return options;
}

/// Returns x at t_s of a handle that is released 1 mm from the hand's intended position.
double Release(int substeps, double t_s) {
  SimulatedDevice device(MakePlain(), MakeHand(0.1, 0.003, 0.2), PoseAt(1), Fine(substeps));
  device.SetIntention({.X_WH = PoseAt(0)});
  for (int i = 0; i < std::lround(t_s / kSimulatedDeviceDt_s); ++i) device.Elapse(kSimulatedDeviceDt_s);
  return device.p_WC_mm().x;
}

TEST(SimulatedDevice, RestsWhereItIsPlaced) {
  SimulatedDevice device(MakePlain(), MakeHand(0.1, 0.003, 0.2), PoseAt(1), Fine());
  device.SetIntention({.X_WH = PoseAt(0), .push_W_N = {0, 3, 0}});
  for (int i = 0; i < 50; ++i) device.Elapse(kSimulatedDeviceDt_s);
  ASSERT_GT(glm::length(device.v_WC_mm_per_s()), 1);
  device.Place(PoseAt(5, 2, -1));
  for (int i = 0; i < 50; ++i) {
    DeviceSample sample;
    ASSERT_TRUE(device.Read(sample));
    EXPECT_EQ(sample.X_WH.p_AB, Vec3(5, 2, -1));
    device.Elapse(kSimulatedDeviceDt_s);
  }
}

TEST(SimulatedDevice, SwingsLikeADampedOscillatorToSecondOrder) {
  // m = 0.3e-3 N s2/mm, b = 0.003, k = 0.2: x = e^(-at) (cos wt + a/w sin wt), a = b/2m, w = sqrt(k/m - a^2).
  const double a = 0.003 / (2 * 0.3e-3);
  const double w = std::sqrt(0.2 / 0.3e-3 - a * a);
  const double t = 0.25;
  const double exact = std::exp(-a * t) * (std::cos(w * t) + a / w * std::sin(w * t));
  const double coarse = std::abs(Release(20, t) - exact);
  const double fine = std::abs(Release(40, t) - exact);
  EXPECT_LT(coarse, 1e-6);
  EXPECT_NEAR(coarse / fine, 4, 0.1);
}

TEST(SimulatedDevice, KeepsItsEnergyWithoutDampingAndFriction) {
  const HandModel hand = MakeHand(0.1, 0, 0.2);
  SimulatedDevice device(MakePlain(), hand, PoseAt(1, 2, -3), Fine());
  device.SetIntention({.X_WH = PoseAt(0)});
  const auto energy = [&] {
    const Vec3 p = device.p_WC_mm();
    const Vec3 v = device.v_WC_mm_per_s();
    return 0.5 * 0.3e-3 * glm::dot(v, v) + 0.5 * 0.2 * glm::dot(p, p);
  };
  const double start = energy();
  for (int i = 0; i < 20000; ++i) device.Elapse(kSimulatedDeviceDt_s);
  EXPECT_NEAR(energy(), start, 1e-9 * start);  // allows for 400,000 rounding errors
}

TEST(SimulatedDevice, PortWorkIsTheWorkOnTheMotors) {
  // The motors simulate a damper of 0.01 N s/mm, and the hand makes a sawing motion. The energy put in equals the loss
  // in the hand's own damper plus the energy at the motors plus the stored energy. Only the motors' side is checked:
  // the held force times the motion in each tick.
  SimulatedDevice device(FindDeviceProfile("omega_3"), FindHandModel("H2"), PoseAt(0), Fine());
  device.SetScript(
      IntentionScript(PoseAt(0), {{.seconds = 2, .X_WH = PoseAt(5), .saw_W_mm = Vec3(0, 3, 0), .saw_Hz = 3}}));
  double by_hand = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 before = device.p_WC_mm();
    const Vec3 f = device.force_N();
    device.Elapse(kSimulatedDeviceDt_s);
    by_hand -= glm::dot(f, device.p_WC_mm() - before);
    ASSERT_TRUE(device.Write(-0.01 * device.v_WC_mm_per_s(), Vec3{0}));
  }
  EXPECT_NEAR(device.port_mJ(), by_hand, 1e-9);
  EXPECT_GT(device.port_mJ(), 1);  // a few mm/s for 2 s at 0.01 N s/mm: of the order of 0.01 * 40^2 / 2 * 2 = 16 mJ
}

TEST(SimulatedDevice, FrictionHoldsSmallForcesAndReducesLargerOnes) {
  DeviceProfile profile = MakePlain();
  profile.friction_N = 0.26;
  SimulatedDevice device(profile, FindHandModel("H0"), PoseAt(0), Fine());
  device.SetIntention({.X_WH = PoseAt(0), .push_W_N = Vec3(0.1, 0.2, 0.12)});  // 0.254 N
  for (int i = 0; i < 5000; ++i) device.Elapse(kSimulatedDeviceDt_s);
  EXPECT_EQ(device.p_WC_mm(), Vec3{0});
  device.SetIntention({.X_WH = PoseAt(0), .push_W_N = Vec3(0.36, 0, 0)});
  for (int i = 0; i < 100; ++i) device.Elapse(kSimulatedDeviceDt_s);
  EXPECT_NEAR(device.v_WC_mm_per_s().x, 0.1 / 0.2e-3 * 0.1, 1e-9);  // (0.36 - 0.26) / m * t
}

TEST(SimulatedDevice, ReadsInStepsOfItsEncoder) {
  DeviceProfile profile = FindDeviceProfile("omni");
  SimulatedDeviceOptions options;
  options.p_TC_mm = Vec3(3, 0, 10);
  const Pose start{glm::angleAxis(0.4, Vec3(0, 1, 0)), Vec3(1, 2, 3)};
  SimulatedDevice device(profile, FindHandModel("H2"), start, options);
  Pose end = start;
  end.p_AB += Vec3(2, 1, 0);
  device.SetScript(IntentionScript(start, {{.seconds = 1, .X_WH = end}}));
  for (int i = 0; i < 1000; ++i) {
    device.Elapse(kSimulatedDeviceDt_s);
    DeviceSample sample;
    ASSERT_TRUE(device.Read(sample));
    const Vec3 read = sample.X_WH.Point(options.p_TC_mm);
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(std::abs(read[k] - device.p_WC_mm()[k]), 0.5 * profile.resolution_mm + 1e-12);
      const double steps = read[k] / profile.resolution_mm;
      EXPECT_NEAR(steps, std::round(steps), 1e-9);
    }
  }
}

TEST(SimulatedDevice, ShortensAForceBeyondItsPeakAndKeepsItsDirection) {
  SimulatedDevice device(FindDeviceProfile("omni"), FindHandModel("H2"), PoseAt(0));
  ASSERT_TRUE(device.Write(Vec3(30, 40, 0), Vec3(100, 0, 0)));
  EXPECT_NEAR(device.force_N().x, 3.3 * 0.6, 1e-12);
  EXPECT_NEAR(device.force_N().y, 3.3 * 0.8, 1e-12);
  EXPECT_EQ(device.saturated_writes(), 1u);
  EXPECT_FALSE(device.Write(Vec3(std::nan(""), 0, 0), Vec3{0}));
  EXPECT_EQ(device.force_N(), Vec3{0});
}

TEST(SimulatedDevice, DelayIsInTicks) {
  SimulatedDeviceOptions options;
  options.delay_ticks = 2;
  SimulatedDevice device(MakePlain(), FindHandModel("H2"), PoseAt(0), options);
  for (int i = 1; i <= 6; ++i) {
    ASSERT_TRUE(device.Write(Vec3(i, 0, 0), Vec3{0}));
    EXPECT_EQ(device.force_N().x, std::max(0, i - 2));
  }
}

TEST(SimulatedDevice, FaultsTakeEffect) {
  SimulatedDevice device(FindDeviceProfile("omega_3"), FindHandModel("H3"), PoseAt(0));
  device.SetIntention({.X_WH = PoseAt(0), .push_W_N = Vec3(1, 0, 0)});
  DeviceSample sample;
  device.SetFaults({.frozen = true});
  ASSERT_TRUE(device.Read(sample));
  for (int i = 0; i < 100; ++i) device.Elapse(kSimulatedDeviceDt_s);
  DeviceSample later;
  ASSERT_TRUE(device.Read(later));
  EXPECT_EQ(later.X_WH.p_AB, sample.X_WH.p_AB);
  EXPECT_GT(device.p_WC_mm().x, 0.1);
  device.SetFaults({.not_a_number = true});
  ASSERT_TRUE(device.Read(later));
  EXPECT_TRUE(std::isnan(later.X_WH.p_AB.x));
  device.SetFaults({.read_fails = true});
  EXPECT_FALSE(device.Read(later));
  device.SetFaults({.write_fails = true});
  EXPECT_FALSE(device.Write(Vec3(1, 0, 0), Vec3{0}));
  EXPECT_EQ(device.force_N(), Vec3{0});
  device.SetFaults({.jump_mm = Vec3(0, 20, 0)});
  ASSERT_TRUE(device.Read(later));
  EXPECT_NEAR(later.X_WH.p_AB.y, 20, 0.01);
  device.SetFaults({});
  ASSERT_TRUE(device.Read(later));
  EXPECT_NEAR(later.X_WH.p_AB.y, 0, 0.01);
}

TEST(SimulatedDevice, InvalidTimeStepsMoveNothing) {
  SimulatedDevice device(FindDeviceProfile("omega_3"), FindHandModel("H3"), PoseAt(0));
  device.SetIntention({.X_WH = PoseAt(5)});
  for (const double dt : {0.0, -1.0, std::nan("")}) device.Elapse(dt);
  EXPECT_EQ(device.time_s(), 0);
  EXPECT_EQ(device.p_WC_mm(), Vec3{0});
  device.Elapse(1e9);  // a pause in a debugger
  EXPECT_NEAR(device.time_s(), 0.1, 1e-12);
}

TEST(SimulatedDevice, HandYieldsToTorqueByItsTorsionalStiffness) {
  // With 6 degrees of freedom, a held torque of 100 N mm on 2000 N mm/rad gives 0.05 rad, approached as 1 - e^(-t/10
  // ms).
  SimulatedDevice device(FindDeviceProfile("ideal"), FindHandModel("H3"), PoseAt(0));
  device.SetIntention({.X_WH = PoseAt(0)});
  ASSERT_TRUE(device.Write(Vec3{0}, Vec3(0, 0, 100)));
  for (int i = 0; i < 10; ++i) device.Elapse(kSimulatedDeviceDt_s);
  DeviceSample sample;
  ASSERT_TRUE(device.Read(sample));
  EXPECT_NEAR(glm::angle(sample.X_WH.R_AB), 0.05 * (1 - std::exp(-1)), 1e-9);
  // A device with 3 degrees of freedom ignores the torque.
  SimulatedDevice forces(FindDeviceProfile("omega_3"), FindHandModel("H3"), PoseAt(0));
  ASSERT_TRUE(forces.Write(Vec3{0}, Vec3(0, 0, 100)));
  for (int i = 0; i < 10; ++i) forces.Elapse(kSimulatedDeviceDt_s);
  ASSERT_TRUE(forces.Read(sample));
  EXPECT_EQ(sample.X_WH.R_AB, Quat(1, 0, 0, 0));
}

TEST(SimulatedDevice, YieldingPushStaysConstantWhileTheToolAdvances) {
  // Against a damper of 0.1 N s/mm, a constant push of 5 N would move the handle at 50 mm/s. If the hand's spring were
  // anchored (k = 0.2 N/mm), it would stop at 25 mm. A spring that yields with a time constant of 0.5 s pulls only with
  // k v 0.5 s.
  SimulatedDevice device(MakePlain(), FindHandModel("H2"), PoseAt(0), Fine());
  device.SetIntention({.X_WH = PoseAt(0), .push_W_N = Vec3(5, 0, 0), .yield_s = 0.5});
  double v = 0;
  for (int i = 0; i < 10000; ++i) {
    device.Elapse(kSimulatedDeviceDt_s);
    v = device.v_WC_mm_per_s().x;
    device.Write(Vec3(-0.1 * v, 0, 0), Vec3{0});
  }
  EXPECT_NEAR(v, 5 / (0.1 + 0.003 + 0.2 * 0.5), 1e-4);
}

TEST(SimulatedDevice, BadOptionsAreRefused) {
  const auto message = [](const SimulatedDeviceOptions& options, const DeviceProfile& profile) -> std::string {
    return test::MessageOf([&] { SimulatedDevice(profile, FindHandModel("H1"), PoseAt(0), options); });
  };
  EXPECT_EQ(message({.substeps = 5}, MakePlain()),
            "simulated device: substeps = 5 is below 20; valid range 20 to 10000");
  EXPECT_EQ(message({.delay_ticks = 17}, MakePlain()),
            "simulated device: delay_ticks = 17 is above 16; valid range 0 to 16");
  EXPECT_EQ(message({}, MakePlain(0)), "device ideal has no mass; it can't be simulated");
}

TEST(IntentionScript, StrokesHaveMinimumJerkAndConsistentVelocity) {
  const Pose end{glm::angleAxis(1.0, Vec3(0, 0, 1)), Vec3(30, 0, 0)};
  const IntentionScript script(PoseAt(0), {{.seconds = 2, .X_WH = end, .saw_W_mm = Vec3(0, 4, 0), .saw_Hz = 2.5},
                                           {.seconds = 1, .X_WH = end, .push_W_N = Vec3(0, 0, -5)}});
  EXPECT_EQ(script.duration_s(), 3);
  double fastest = 0;
  for (double t = 0.001; t < 2.999; t += 0.0007) {
    const Intention wanted = script.Calc(t);
    const double h = 1e-5;
    const Vec3 slope = (script.Calc(t + h).X_WH.p_AB - script.Calc(t - h).X_WH.p_AB) / (2 * h);
    // The error of the central difference is h^2/6 times the third derivative (60 L/T^3 and A w^3), plus rounding of
    // 1e-10.
    EXPECT_LT(glm::length(slope - wanted.v_W_mm_per_s), 1e-4) << t;
    fastest = std::max(fastest, wanted.v_W_mm_per_s.x);
  }
  EXPECT_NEAR(fastest, 1.875 * 30 / 2, 1e-3);  // 15/8 L/T
  EXPECT_NEAR(glm::angle(script.Calc(1).X_WH.R_AB), 0.5, 1e-12);
  EXPECT_NEAR(script.Calc(2.15).push_W_N.z, -2.5, 1e-12);  // half of the 0.3 s
  EXPECT_EQ(script.Calc(99).X_WH.p_AB, end.p_AB);
  EXPECT_EQ(script.Calc(-5).X_WH.p_AB, Vec3{0});
}

TEST(IntentionScript, BadStepsAreNamed) {
  const auto message = [](IntentionStep step) -> std::string {
    return test::MessageOf([&] { IntentionScript(PoseAt(0), {IntentionStep{}, step}); });
  };
  EXPECT_EQ(message({.seconds = 0}), "step 2 of the hand: seconds = 0 is below 0.001; valid range 0.001 to 1000000 s");
  EXPECT_EQ(message({.saw_Hz = 12}), "step 2 of the hand: saw_Hz = 12 is above 10; valid range 0 to 10 Hz");
  EXPECT_EQ(message({.X_WH = PoseAt(std::nan(""))}),
            "the end pose of step 2 of the hand is not valid or outside the world");
}

}  // namespace
}  // namespace kerf
