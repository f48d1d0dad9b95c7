// The device servo as seen by the loop and by the user: the tool never jumps, and there is force only when allowed.
#include "device/drivers/device_servo.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <numbers>

#include "device/drivers/reported_device.h"

namespace kerf {
namespace {

using test::PatientOptions;
using test::ReportedDevice;
using test::Served;
using test::WaitFor;

constexpr std::uint32_t kClutch = 1;
constexpr std::uint32_t kRight = 4;
constexpr std::uint32_t kLeft = 8;
// Tolerance for lengths of about 100 mm in doubles, rotated a few times.
constexpr double kExact_mm = 1e-9;

const Vec3 kHandle_mm{12, -7, 30};
const Vec3 kDeviceServoForce_W_N{0.5, -1, 1.5};

Pose MakePlace() {
  return {glm::angleAxis(0.7, glm::normalize(Vec3{1, 2, -1})), {40, -25, 60}};
}

ToolCoupling MakeTool() {
  return {.p_TC_mm = {3, 4, 80}, .stiffness_N_per_mm = 2};
}

double CalcAngle(const Quat& a, const Quat& b) {
  const Quat turn = a * glm::conjugate(b);
  return 2 * std::atan2(std::hypot(turn.x, turn.y, turn.z), std::abs(turn.w));
}

void ExpectPose(const Pose& X, const Pose& expected) {
  EXPECT_LE(glm::length(X.p_AB - expected.p_AB), kExact_mm);
  EXPECT_LE(CalcAngle(X.R_AB, expected.R_AB), 1e-9);
}

/// Puts the device away from its middle at the start.
void MoveOffCentre(ReportedDevice::State& state) {
  state.sample.X_DH.p_AB = kHandle_mm;
}

TEST(DeviceServo, ReturnsNoPoseBeforeItIsEngagedAndThenTheToolsPose) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    MoveOffCentre(state);
    state.sample.homed = false;
  });
  served.servo->SetTool(MakePlace(), MakeTool());
  ASSERT_TRUE(served.Await(ServoState::kHoming));
  ASSERT_TRUE(served.AwaitMessage("pull it out"));
  served.device->PassRounds(20);
  EXPECT_FALSE(served.Tick(kDeviceServoForce_W_N));
  ExpectPose(served.sample.X_WH, MakePlace());
  served.device->With([](ReportedDevice::State& state) { state.sample.homed = true; });
  ASSERT_TRUE(served.Await(ServoState::kWaiting));
  EXPECT_FALSE(served.Tick(kDeviceServoForce_W_N));
  served.servo->Agree();
  ASSERT_TRUE(served.Await(ServoState::kEngaged));
  served.MoveHandle({-20, 15, 5});
  ASSERT_TRUE(served.Tick());
  ExpectPose(served.sample.X_WH, MakePlace());
  EXPECT_EQ(served.device->Look().largest_N, 0);
}

TEST(DeviceServo, TheHandleMovesTheToolByTheScaleInTheDevicesFrame) {
  DeviceServoOptions options = PatientOptions();
  options.motion_scale = 2.5;
  options.R_WD = glm::angleAxis(1.1, glm::normalize(Vec3{-1, 3, 2}));
  Served served(options, MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  ASSERT_TRUE(served.Tick());
  const Vec3 motion_D_mm{3, -2, 1};
  served.MoveHandle(kHandle_mm + motion_D_mm);
  ASSERT_TRUE(served.Tick());
  Pose expected = MakePlace();
  expected.p_AB += 2.5 * (options.R_WD * motion_D_mm);
  ExpectPose(served.sample.X_WH, expected);
  EXPECT_EQ(served.servo->profile().peak_force_N, FindDeviceProfile("falcon").peak_force_N);
}

TEST(DeviceServo, HandleHoldsNoToolUntilTheOrientationIsSet) {
  DeviceServoOptions options = PatientOptions();
  options.reported_orientation = true;
  Served served(options, MoveOffCentre);
  served.servo->SetOrientation(glm::angleAxis(0.3, Vec3{1, 0, 0}));  // left from an earlier session
  served.Engage(MakePlace(), MakeTool());
  EXPECT_FALSE(served.Tick());
  served.MoveHandle(kHandle_mm + Vec3{0, 0, 9});
  EXPECT_FALSE(served.Tick());
  ExpectPose(served.sample.X_WH, MakePlace());
  const Quat R_WD = glm::angleAxis(1.1, glm::normalize(Vec3{-1, 3, 2}));
  served.servo->SetOrientation(R_WD);
  ASSERT_TRUE(served.Tick());
  ExpectPose(served.sample.X_WH, MakePlace());
  const Vec3 motion_D_mm{3, -2, 1};
  served.MoveHandle(kHandle_mm + Vec3{0, 0, 9} + motion_D_mm);
  ASSERT_TRUE(served.Tick());
  Pose expected = MakePlace();
  expected.p_AB += R_WD * motion_D_mm;
  ExpectPose(served.sample.X_WH, expected);
}

TEST(DeviceServo, TheForceReachesTheDriverInTheDevicesFrame) {
  DeviceServoOptions options = PatientOptions();
  options.motion_scale = 3;
  options.R_WD = glm::angleAxis(0.4, glm::normalize(Vec3{2, -1, 1}));
  Served served(options, MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  const Vec3 f_D_N = glm::conjugate(options.R_WD) * kDeviceServoForce_W_N;
  // When the force has risen to its 1.9 N within 1e-12, the stiffness has risen to the same fraction of its full value.
  // The command is copied in the same check, because the next command may differ.
  DriverCommand reported;
  ASSERT_TRUE(served.TickUntil(kDeviceServoForce_W_N, [&] {
    reported = served.device->Look().reported;
    return glm::length(reported.f_D_N - f_D_N) <= 1e-12;
  }));
  EXPECT_TRUE(reported.engaged);
  EXPECT_LE(glm::length(reported.p_D_mm - kHandle_mm), kExact_mm);
  // 1 mm of motion at the handle is 3 mm at the tool.
  EXPECT_NEAR(reported.stiffness_N_per_mm, 3 * 2, 1e-9);
  EXPECT_EQ(reported.damping_Ns_per_mm, 0);  // the force already includes the coupling's damping
}

TEST(DeviceServo, ClutchDetachesTheHandleFromTheTool) {
  Served served(PatientOptions(), MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  const Vec3 f_D_N = glm::conjugate(kFacingPatient) * kDeviceServoForce_W_N;
  ASSERT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, f_D_N));
  served.Press(kClutch);
  served.Tick(kDeviceServoForce_W_N);  // the tick that notices the button
  for (int tick = 0; tick < 60; ++tick) ASSERT_TRUE(served.Tick(kDeviceServoForce_W_N));
  ASSERT_TRUE(
      WaitFor([&] { return served.device->Look().reported.f_D_N == Vec3(0); }, 10));  // before it is stale, at 20 s
  served.MoveHandle({-30, 30, -10});
  ASSERT_TRUE(served.Tick(kDeviceServoForce_W_N));
  ExpectPose(served.sample.X_WH, MakePlace());
  EXPECT_EQ(served.device->Look().reported.f_D_N, Vec3(0));

  served.Press(0);
  ASSERT_TRUE(served.Tick(kDeviceServoForce_W_N));
  ExpectPose(served.sample.X_WH, MakePlace());
  served.MoveHandle({-30, 31, -10});
  ASSERT_TRUE(served.Tick(kDeviceServoForce_W_N));
  Pose expected = MakePlace();
  expected.p_AB += kFacingPatient * Vec3{0, 1, 0};
  ExpectPose(served.sample.X_WH, expected);
  // The force returns over 0.3 s of ticks; after 100 ticks it is at most a third of its full value plus one tick's
  // rise.
  served.device->With([](ReportedDevice::State& state) { state.largest_N = 0; });
  for (int tick = 0; tick < 97; ++tick) ASSERT_TRUE(served.Tick(kDeviceServoForce_W_N));
  EXPECT_LE(served.device->Look().largest_N, glm::length(kDeviceServoForce_W_N) * 100 / 300);
  EXPECT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, f_D_N));
}

TEST(DeviceServo, TheToolTurnsAboutTheHandlesPointNoFasterThanAHand) {
  Served served(PatientOptions(), MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  ASSERT_TRUE(served.Tick());
  const Quat R_wanted = glm::angleAxis(0.5, Vec3{0, 1, 0}) * MakePlace().R_AB;
  served.servo->SetToolOrientation(-R_wanted);  // q and -q are the same orientation
  const Vec3 p_WC_mm = MakePlace().Point(MakeTool().p_TC_mm);
  Quat R_before = MakePlace().R_AB;
  int ticks = 0;
  for (; ticks < 1000 && CalcAngle(served.sample.X_WH.R_AB, R_wanted) > 1e-6; ++ticks) {
    ASSERT_TRUE(served.Tick());
    EXPECT_LE(CalcAngle(served.sample.X_WH.R_AB, R_before), 2 * 0.001 * (1 + 1e-6));
    EXPECT_LE(glm::length(served.sample.X_WH.Point(MakeTool().p_TC_mm) - p_WC_mm), kExact_mm);
    R_before = served.sample.X_WH.R_AB;
  }
  EXPECT_NEAR(ticks, 250, 1);
  // From there, the handle still moves the tool.
  served.MoveHandle(kHandle_mm + Vec3{0, 0, 5});
  ASSERT_TRUE(served.Tick());
  EXPECT_LE(glm::length(served.sample.X_WH.Point(MakeTool().p_TC_mm) - p_WC_mm - kFacingPatient * Vec3{0, 0, 5}),
            kExact_mm);
}

TEST(DeviceServo, DeviceThatSensesOrientationRotatesTheTool) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    MoveOffCentre(state);
    state.traits.senses_orientation = true;
    state.sample.X_DH.R_AB = glm::angleAxis(0.3, Vec3{0, 0, 1});
  });
  served.Engage(MakePlace(), MakeTool());
  ASSERT_TRUE(served.Tick());
  ExpectPose(served.sample.X_WH, MakePlace());
  served.servo->SetToolOrientation({1, 0, 0, 0});  // has no effect on this device
  const Quat turn_D = glm::angleAxis(0.2, Vec3{1, 0, 0});
  served.device->With([&](ReportedDevice::State& state) { state.sample.X_DH.R_AB = turn_D * state.sample.X_DH.R_AB; });
  ASSERT_TRUE(served.device->PassRounds());
  ASSERT_TRUE(served.Tick());
  const Quat R_expected = kFacingPatient * turn_D * glm::conjugate(kFacingPatient) * MakePlace().R_AB;
  EXPECT_LE(CalcAngle(served.sample.X_WH.R_AB, R_expected), 1e-9);
  EXPECT_LE(glm::length(served.sample.X_WH.Point(MakeTool().p_TC_mm) - MakePlace().Point(MakeTool().p_TC_mm)),
            kExact_mm);
}

TEST(DeviceServo, LeftHandSwapsButtonsAndMirrorsTheFrame) {
  DeviceServoOptions options = PatientOptions();
  options.left_handed = true;
  options.R_WD = kFacingPatient * glm::angleAxis(0.6, Vec3{0, 1, 0});
  Served served(options, MoveOffCentre);
  served.Engage(MakePlace());
  served.Press(kRight);
  ASSERT_TRUE(served.Tick());
  EXPECT_EQ(served.sample.buttons, kLeft);
  served.Press(kLeft | 2);
  ASSERT_TRUE(served.Tick());
  EXPECT_EQ(served.sample.buttons, kRight | 2);
  served.MoveHandle(kHandle_mm + Vec3{1, 0, 0});
  ASSERT_TRUE(served.Tick());
  const Vec3 moved = served.sample.X_WH.p_AB - MakePlace().p_AB;
  EXPECT_LE(glm::length(moved - kFacingPatient * glm::angleAxis(-0.6, Vec3{0, 1, 0}) * Vec3{1, 0, 0}), kExact_mm);
}

TEST(DeviceServo, AfterUnpluggingUnderForceTheToolContinuesFromItsPose) {
  Served served(PatientOptions(), MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  const Vec3 f_D_N = glm::conjugate(kFacingPatient) * kDeviceServoForce_W_N;
  served.MoveHandle(kHandle_mm + Vec3{4, 0, 0});
  ASSERT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, f_D_N));
  const Pose X_WT = served.sample.X_WH;
  served.Messages();
  served.device->With([](ReportedDevice::State& state) {
    state.is_there = false;
    state.sample.X_DH.p_AB = {-40, 20, 0};
    state.largest_N = 0;
  });
  ASSERT_TRUE(served.TickUntil(kDeviceServoForce_W_N, [&] { return served.servo->state() == ServoState::kClosed; }));
  EXPECT_FALSE(served.Tick(kDeviceServoForce_W_N));
  ExpectPose(served.sample.X_WH, X_WT);
  EXPECT_TRUE(served.AwaitMessage("reported: is gone: no force, and the tool is stopped"));

  served.servo->Agree();  // has no effect, because no device is open
  served.device->With([](ReportedDevice::State& state) { state.is_there = true; });
  ASSERT_TRUE(served.TickUntil(kDeviceServoForce_W_N, [&] { return served.servo->state() == ServoState::kWaiting; }));
  for (int i = 0; i < 300; ++i) {
    EXPECT_FALSE(served.Tick(kDeviceServoForce_W_N));
    served.device->PassRounds(1);
  }
  EXPECT_EQ(served.servo->state(), ServoState::kWaiting);
  EXPECT_EQ(served.device->Look().largest_N, 0);
  EXPECT_EQ(served.device->Look().opened, 2);
  EXPECT_TRUE(served.AwaitMessage("is connected again; press a button on it, or agree here"));

  served.Press(2);
  ASSERT_TRUE(served.TickUntil(kDeviceServoForce_W_N, [&] { return served.servo->state() == ServoState::kEngaged; }));
  ASSERT_TRUE(served.device->PassRounds());
  ASSERT_TRUE(served.Tick(kDeviceServoForce_W_N));
  ExpectPose(served.sample.X_WH, X_WT);
  EXPECT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, f_D_N));
  ExpectPose(served.sample.X_WH, X_WT);
}

TEST(DeviceServo, AgreementWhileEngagedIsNotKept) {
  Served served(PatientOptions(), MoveOffCentre);
  served.Engage(MakePlace());
  served.servo->Agree();
  ASSERT_TRUE(served.device->PassRounds());
  served.device->With([](ReportedDevice::State& state) { state.sample.homed = false; });
  ASSERT_TRUE(served.Await(ServoState::kHoming));
  served.device->With([](ReportedDevice::State& state) { state.sample.homed = true; });
  ASSERT_TRUE(served.Await(ServoState::kWaiting));
  served.device->PassRounds(50);
  EXPECT_EQ(served.servo->state(), ServoState::kWaiting);
}

TEST(DeviceServo, AgreementInARoundWithoutAnAnswerIsKept) {
  Served served;
  served.servo->SetTool(MakePlace(), {});
  ASSERT_TRUE(served.Await(ServoState::kWaiting));
  served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
  ASSERT_TRUE(served.device->PassRounds());
  served.servo->Agree();
  ASSERT_TRUE(served.device->PassRounds(5));
  served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kSample; });
  EXPECT_TRUE(served.Await(ServoState::kEngaged));
}

TEST(DeviceServo, ReopeningIsRetriedUntilItSucceeds) {
  Served served;
  served.Engage(MakePlace());
  served.device->With([](ReportedDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(served.Await(ServoState::kClosed));
  served.device->With([](ReportedDevice::State& state) {
    state.is_there = true;
    state.fails_otherwise = true;
  });
  std::string said;
  ASSERT_TRUE(WaitFor([&] { return (said += served.Messages()).ends_with("reported: no memory, perhaps\n"); })) << said;
  EXPECT_EQ(served.device->Look().opened, 1);
  served.device->With([](ReportedDevice::State& state) {
    state.fails_otherwise = false;
    state.fails_to_start = "its firmware is not the right one";
  });
  ASSERT_TRUE(WaitFor([&] { return served.device->Look().opened > 4; }));
  EXPECT_EQ(served.Messages(), "reported: its firmware is not the right one\n");  // the message is reported once
  EXPECT_EQ(served.servo->state(), ServoState::kClosed);
  served.device->With([](ReportedDevice::State& state) { state.fails_to_start.clear(); });
  EXPECT_TRUE(served.Await(ServoState::kWaiting));
}

TEST(DeviceServo, ASecondSessionBeginsWhereItsToolIs) {
  Served served(PatientOptions(), MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  ASSERT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, glm::conjugate(kFacingPatient) * kDeviceServoForce_W_N));
  served.MoveHandle({0, 25, -25});
  served.servo->SetToolOrientation({1, 0, 0, 0});  // left from the first engagement
  const Pose X_WT{glm::angleAxis(-1.0, Vec3{0, 0, 1}), {-100, 10, 0}};
  served.servo->SetTool(X_WT, {.p_TC_mm = {0, 0, 50}, .stiffness_N_per_mm = 1});
  served.servo->Elapse(0.001);
  ASSERT_TRUE(served.servo->Read(served.sample));
  ExpectPose(served.sample.X_WH, X_WT);
  served.MoveHandle({0, 26, -25});
  ASSERT_TRUE(served.Tick());
  Pose expected = X_WT;
  expected.p_AB += kFacingPatient * Vec3{0, 1, 0};
  ExpectPose(served.sample.X_WH, expected);
}

TEST(DeviceServo, SilentDeviceHasNoForceAndTheToolDoesNotJumpAfterwards) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.1;
  Served served(options, MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  const Vec3 f_D_N = glm::conjugate(kFacingPatient) * kDeviceServoForce_W_N;
  ASSERT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, f_D_N));
  served.device->With([](ReportedDevice::State& state) {
    state.end = RoundEnd::kNoAnswer;
    state.sample.X_DH.p_AB = {-10, 0, 20};
  });
  ASSERT_TRUE(served.TickUntil(kDeviceServoForce_W_N, [&] { return served.servo->state() == ServoState::kSilent; }));
  EXPECT_FALSE(served.Tick(kDeviceServoForce_W_N));
  ASSERT_TRUE(WaitFor([&] { return served.device->Look().reported.f_D_N == Vec3(0); }));
  EXPECT_TRUE(served.AwaitMessage("does not answer: no force"));
  served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kSample; });
  ASSERT_TRUE(served.Await(ServoState::kEngaged));
  ASSERT_TRUE(WaitFor(
      [&] { return served.Tick(kDeviceServoForce_W_N); }));  // if the machine stalls, the device is silent again
  ExpectPose(served.sample.X_WH, MakePlace());  // although it answered from another place, in the same engagement
  EXPECT_TRUE(served.AwaitForce(kDeviceServoForce_W_N, f_D_N));
  EXPECT_TRUE(served.AwaitMessage("answers again"));
}

TEST(DeviceServo, ForceIsZeroAfterTheLoopHasStopped) {
  DeviceServoOptions options = PatientOptions();
  options.servo.gate.stale_s = 0.3;
  Served served(options, MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  ASSERT_TRUE(
      served.TickUntil(kDeviceServoForce_W_N, [&] { return glm::length(served.device->Look().reported.f_D_N) > 1; }));
  // A stall of the machine also ends the force, but the force returns if the last command is not stale yet.
  const auto stale = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.servo.gate.stale_s);
  EXPECT_TRUE(WaitFor(
      [&] { return std::chrono::steady_clock::now() > stale && served.device->Look().reported.f_D_N == Vec3(0); }));
  served.device->PassRounds();
  served.device->With([](ReportedDevice::State& state) { state.largest_N = 0; });
  served.device->PassRounds(50);
  EXPECT_EQ(served.device->Look().largest_N, 0);
  EXPECT_EQ(served.servo->state(), ServoState::kEngaged);
}

TEST(DeviceServo, OldSampleIsNotUsed) {
  DeviceServoOptions options = PatientOptions();
  options.max_sample_age_s = 0.2;
  Served served(options, MoveOffCentre);
  served.Engage(MakePlace(), MakeTool());
  served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kBadAnswer; });
  EXPECT_TRUE(WaitFor([&] { return !served.Tick(); }));
  EXPECT_EQ(served.servo->state(), ServoState::kEngaged);
  ExpectPose(served.sample.X_WH, MakePlace());
}

TEST(DeviceServo, EndsInEachStateWithoutForce) {
  struct Case {
    const char* name;
    std::function<void(Served&)> reach;
    bool is_open = true;
  };
  const std::vector<Case> cases = {
      {.name = "homing",
       .reach =
           [](Served& served) {
             served.device->With([](ReportedDevice::State& state) { state.sample.homed = false; });
             ASSERT_TRUE(served.Await(ServoState::kHoming));
           }},
      {.name = "waiting", .reach = [](Served& served) { ASSERT_TRUE(served.Await(ServoState::kWaiting)); }},
      {.name = "engaged",
       .reach =
           [](Served& served) {
             served.Engage(MakePlace(), MakeTool());
             ASSERT_TRUE(
                 served.AwaitForce(kDeviceServoForce_W_N, glm::conjugate(kFacingPatient) * kDeviceServoForce_W_N));
           }},
      {.name = "silent",
       .reach =
           [](Served& served) {
             served.Engage(MakePlace(), MakeTool());
             served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
             ASSERT_TRUE(served.Await(ServoState::kSilent));
           }},
      {.name = "gone",
       .reach =
           [](Served& served) {
             served.device->With([](ReportedDevice::State& state) { state.is_there = false; });
             ASSERT_TRUE(served.Await(ServoState::kClosed));
           },
       .is_open = false},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    DeviceServoOptions options = PatientOptions();
    options.servo.silent_s = 0.1;
    Served served(options, MoveOffCentre);
    c.reach(served);
    served.servo.reset();
    const ReportedDevice::State end = served.device->Look();
    if (c.is_open) {
      EXPECT_EQ(end.reported.f_D_N, Vec3(0));
      EXPECT_FALSE(end.reported.engaged);
      EXPECT_EQ(end.stopped, 1);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_EQ(served.device->Look().rounds, end.rounds);
  }
}

TEST(DeviceServo, ReportedPeaksAreLimitedByTheTable) {
  // A bridge whose program claims more than any Touch can do; its claims are the same each time it is opened.
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    state.profile = FindDeviceProfile("touch");
    state.profile.peak_force_N = 10;
    state.profile.peak_torque_Nmm = 100;
  });
  EXPECT_EQ(served.servo->profile().peak_force_N, FindDeviceProfile("touch").peak_force_N);
  EXPECT_EQ(served.servo->profile().peak_torque_Nmm, 0);
  served.Engage(MakePlace());
  served.device->With([](ReportedDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(served.Await(ServoState::kClosed));
  served.device->With([](ReportedDevice::State& state) { state.is_there = true; });
  EXPECT_TRUE(served.Await(ServoState::kWaiting));
}

TEST(DeviceServo, TableDoesNotLimitAnArmWithItsOwnFile) {
  DeviceServoOptions options = PatientOptions();
  options.own_figures = true;
  Served served(options, [](ReportedDevice::State& state) {
    state.profile = FindDeviceProfile("wooden");
    state.profile.peak_force_N = 2 * FindDeviceProfile("wooden").peak_force_N;
  });
  EXPECT_EQ(served.servo->profile().peak_force_N, 2 * FindDeviceProfile("wooden").peak_force_N);
  served.Engage(MakePlace());
  // This force is more than the gate would allow with the table's peak. With the file's peak it is allowed, and it is
  // low enough that the motors' heat, assumed for half of that peak, does not limit it for several seconds.
  const Vec3 f_W_N{0, 0, 1.2 * FindDeviceProfile("wooden").peak_force_N};
  EXPECT_TRUE(served.AwaitForce(f_W_N, glm::conjugate(kFacingPatient) * f_W_N));
}

TEST(DeviceServo, ConstructorThrowsIfTheDeviceCannotBeOpened) {
  const auto device = std::make_shared<ReportedDevice>();
  const auto make = [&](const DeviceServoOptions& options) {
    DeviceServo("reported", test::OpenReported(device), options, {});
  };
  device->With([](ReportedDevice::State& state) { state.fails_to_start = "no firmware"; });
  EXPECT_THROW(make(PatientOptions()), Error);
  device->With([](ReportedDevice::State& state) { state.fails_to_start.clear(); });
  DeviceServoOptions options = PatientOptions();
  options.motion_scale = 21;
  EXPECT_THROW(make(options), Error);
  options = PatientOptions();
  options.servo.silent_s = 0;
  EXPECT_THROW(make(options), Error);
}

}  // namespace
}  // namespace kerf
