// Tests of a scene on a device: settings taken from the device's properties, and a spring-centred cap compared with
// closed forms.
#include "session/held_device/hold_tool.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <numbers>

#include "device/drivers/reported_device.h"
#include "support/folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::PatientOptions;
using test::ReportedDevice;
using test::Served;
using testing::HasSubstr;

TEST(HoldTool, SceneTakesTheDevicesProperties) {
  DeviceServoOptions options = PatientOptions();
  options.motion_scale = 0.5;
  options.left_handed = true;
  Served served(options, [](ReportedDevice::State& state) { state.profile = FindDeviceProfile("omni"); });
  Scene scene;
  SetDevice(scene, *served.servo);
  EXPECT_EQ(scene.device.profile, "omni");
  EXPECT_EQ(scene.device.motion_scale, 0.5);
  EXPECT_TRUE(scene.device.left_handed);
  EXPECT_EQ(scene.device.delay_ticks, 2);
  // The slew rate is below the limit at which a safety gate detects a fault, relative to the 3.3 N.
  EXPECT_LT(scene.device.slew_N_per_s, SafetyGateOptions{}.max_slew_per_s * 3.3);
  EXPECT_GT(scene.device.slew_N_per_s, 0.5 * SafetyGateOptions{}.max_slew_per_s * 3.3);

  scene.device.slew_N_per_s = 20;
  scene.device.delay_ticks = 5;
  SetDevice(scene, *served.servo);
  EXPECT_EQ(scene.device.slew_N_per_s, 20);
  EXPECT_EQ(scene.device.delay_ticks, 5);

  Scene back;
  back.device.orientation = glm::angleAxis(0.3, Vec3{0, 1, 0});
  back.device.motion_scale = 4;
  EXPECT_EQ(MakeServoOptions(back).motion_scale, 4);
  EXPECT_EQ(MakeServoOptions(back).R_WD, back.device.orientation);
}

TEST(HoldTool, DeviceWithoutForceDoesNotChangeTheScene) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) { state.traits.makes_force = false; });
  Scene scene;
  SetDevice(scene, *served.servo);
  EXPECT_EQ(scene.device.profile, Scene().device.profile);
  EXPECT_EQ(scene.device.delay_ticks, 0);
}

TEST(HoldTool, RefusesProfileWithMoreForceThanTheDevice) {
  Served weak(PatientOptions(), [](ReportedDevice::State& state) { state.profile.peak_force_N = 2; });
  Scene scene;
  EXPECT_THAT(test::MessageOf([&] { SetDevice(scene, *weak.servo); }),
              HasSubstr("outputs at most 2 N, but the profile 'falcon' states 8 N"));

  Served unknown(PatientOptions(), [](ReportedDevice::State& state) { state.profile.name = "somebodys_own"; });
  Scene other;
  EXPECT_THAT(test::MessageOf([&] { SetDevice(other, *unknown.servo); }),
              HasSubstr("name a similar one with --profile"));
  other.device.given = true;  // the scene specifies the device
  other.device.profile = "touch";
  SetDevice(other, *unknown.servo);
  EXPECT_EQ(other.device.profile, "touch");

  // The same applies to a table given by the scene.
  const test::Folder folder;
  const std::string file = folder.file("profiles.csv");
  std::ifstream table(KERF_SOURCE_DIR "/volumes/device_profiles.csv");
  std::ofstream(file) << table.rdbuf();
  Scene with_table;
  with_table.device.file = file;
  with_table.device.profile = "omega_6";
  Served falcon;
  EXPECT_THAT(test::MessageOf([&] { SetDevice(with_table, *falcon.servo); }),
              HasSubstr("the profile 'omega_6' states 12 N"));
  with_table.device.profile = "omni";
  SetDevice(with_table, *falcon.servo);
  EXPECT_EQ(with_table.device.profile, "omni");
}

TEST(HoldTool, WaitsForTheHandleAndCanBeStopped) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) { state.sample.homed = false; });
  std::atomic<bool> stop{false};
  bool stops = true;
  std::string said;
  const LoopDevice held = MakeLoopDevice(*served.servo, &stop, [&](const std::string& text) {
    said += text;
    stop.store(stops);
  });
  CouplingParams coupling;
  coupling.p_TC_mm = {0, 0, 70};
  coupling.stiffness_N_per_mm = 3;
  EXPECT_THAT(test::MessageOf([&] { held.begin({}, coupling, 0.25); }), HasSubstr("stopped while waiting"));
  EXPECT_THAT(said, HasSubstr("pull it out"));

  // The device is homed, but at the edge of the workspace: the program asks the user to move to the middle.
  stop.store(false);
  served.device->With([](ReportedDevice::State& state) {
    state.sample.homed = true;
    state.sample.X_DH.p_AB = {0, 0, -0.8 * FindDeviceProfile("falcon").workspace_radius_mm};
  });
  said.clear();
  EXPECT_THAT(test::MessageOf([&] { held.begin({}, coupling, 0.25); }), HasSubstr("stopped while waiting"));
  EXPECT_THAT(said, HasSubstr("hold the handle still in the middle"));

  stop.store(false);
  stops = false;
  served.device->With([](ReportedDevice::State& state) { state.sample.X_DH.p_AB = {0, 0, 3}; });
  const Pose X_WT{{1, 0, 0, 0}, {5, 6, 7}};
  Device& device = held.begin(X_WT, coupling, 0.25);
  EXPECT_EQ(&device, served.servo.get());
  EXPECT_TRUE(held.in_real_time);
  ASSERT_TRUE(served.device->PassRounds());
  ASSERT_TRUE(served.Tick());
  EXPECT_LE(glm::length(served.sample.X_WH.p_AB - X_WT.p_AB), 1e-12);
  ASSERT_TRUE(served.AwaitForce({0, 1, 0}, glm::conjugate(kFacingPatient) * Vec3{0, 1, 0}));
  EXPECT_NEAR(served.device->Look().reported.stiffness_N_per_mm, 3 * 0.25, 1e-9);
}

TEST(SetDevice, CouplingAllowsForTheDelayOfTheDevicesRounds) {
  struct Case {
    double loop_Hz, device_Hz;
    int delay_ticks;  // one tick of the loop, plus the number that begin during a round of the device
  };
  for (const Case& c : {Case{1000, 1000, 2}, Case{500, 1000, 2}, Case{4000, 1000, 5}, Case{1000, 300, 5}}) {
    SCOPED_TRACE(c.loop_Hz);
    const Served served(PatientOptions(), [&](ReportedDevice::State& state) { state.traits.rate_hz = c.device_Hz; });
    Scene scene;
    scene.loop.rate_hz = c.loop_Hz;
    SetDevice(scene, *served.servo);
    EXPECT_EQ(scene.device.delay_ticks, c.delay_ticks);
  }
  const Served slow(PatientOptions(), [](ReportedDevice::State& state) { state.traits.rate_hz = 50; });
  Scene scene;
  scene.loop.rate_hz = 1000;
  EXPECT_THAT(test::MessageOf([&] { SetDevice(scene, *slow.servo); }), HasSubstr("rate_hz must be 750 at most"));
}

TEST(MoveByDeflection, MovesAndRotatesAtItsSpeeds) {
  const Pose X_WH{glm::angleAxis(0.8, glm::normalize(Vec3{1, -1, 2})), {10, 20, 30}};
  const Quat R_WD = glm::angleAxis(0.5, glm::normalize(Vec3{3, 1, 1}));
  const Vec3 p_TC_mm{0, 5, 60};
  const DeflectionSpeeds speeds{.mm_per_s = 50, .rad_per_s = 0.5};
  Pose X = MoveByDeflection(X_WH, {}, R_WD, p_TC_mm, speeds, 0.1);
  EXPECT_LE(glm::length(X.p_AB - X_WH.p_AB), 1e-12);
  X = MoveByDeflection(X_WH, {0.5, 0, -1, 0, 0, 0}, R_WD, p_TC_mm, speeds, 0.1);
  EXPECT_LE(glm::length(X.p_AB - X_WH.p_AB - R_WD * Vec3{2.5, 0, -5}), 1e-12);
  // The handle is rotated by half a turn in many steps, about the device's axis, with the point at rest.
  X = X_WH;
  const int steps = 1000;
  for (int i = 0; i < steps; ++i) {
    X = MoveByDeflection(X, {0, 0, 0, 0, 1, 0}, R_WD, p_TC_mm, speeds, std::numbers::pi / 0.5 / steps);
  }
  EXPECT_LE(glm::length(X.Point(p_TC_mm) - X_WH.Point(p_TC_mm)), 1e-9);
  const Vec3 axis_W = R_WD * Vec3{0, 1, 0};
  const Vec3 arm = X_WH.Vector({1, 0, 0});
  EXPECT_LE(glm::length(X.Vector({1, 0, 0}) - (2 * glm::dot(arm, axis_W) * axis_W - arm)), 1e-9);
}

TEST(DeflectionHand, PushedCapMovesTheHandleAndBoneHoldsItBack) {
  Served cap(PatientOptions(), [](ReportedDevice::State& state) {
    state.traits.makes_force = false;
    state.traits.homes = false;
    state.traits.motion = DriverMotion::kDeflection;
    state.sample.deflection = {1, 0, 0, 0, 0, 0};
  });
  ASSERT_TRUE(cap.Await(ServoState::kEngaged));  // no consent is needed, because the cap exerts no force
  const Pose X_WH{{1, 0, 0, 0}, {1, 2, 3}};
  SimulatedDeviceOptions options;
  options.quantise = false;
  const auto go = [&](const Vec3& f_W_N) {
    SimulatedDevice device(FindDeviceProfile("omega_6"), FindHandModel("H3"), X_WH, options);
    DeflectionHand hand(device, *cap.servo, Quat{1, 0, 0, 0}, Vec3{0});
    cap.device->With([](ReportedDevice::State& state) { state.sample.deflection[0] = 1; });
    EXPECT_TRUE(cap.device->PassRounds());
    const HeapGuard guard;
    for (int tick = 0; tick < 500; ++tick) {  // 30 mm at 60 mm/s, then some time to arrive
      hand.Advance(0.001);
      device.Write(f_W_N, Vec3{0});
      device.Elapse(0.001);
    }
    return device.p_WC_mm();
  };
  const Vec3 free = go(Vec3{0});
  // The cap follows with the lag of the hand's second-order response, 40 ms, and that of its spring.
  EXPECT_NEAR(free.x - X_WH.p_AB.x, 30, 60 * 0.1);
  EXPECT_NEAR(free.y, X_WH.p_AB.y, 1e-9);
  // A force holds the cap back by the compliance of the hand's spring, within the device's friction.
  const MouseHandParams hand;
  const double friction_mm = FindDeviceProfile("omega_6").friction_N / hand.stiffness_N_per_mm;
  const Vec3 held = go(Vec3{-3, 0, 0});
  EXPECT_NEAR(free.x - held.x, 3 / hand.stiffness_N_per_mm, 2 * friction_mm + 0.3);
}

}  // namespace
}  // namespace kerf
