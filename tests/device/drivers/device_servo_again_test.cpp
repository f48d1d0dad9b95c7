// Tests of a device that was unplugged and plugged in again, or that the user must first make ready: its messages are
// correct, and it is not used before the user has agreed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "device/drivers/device_servo.h"
#include "device/drivers/reported_device.h"

namespace kerf {
namespace {

using test::PatientOptions;
using test::ReportedDevice;
using test::Served;
using test::WaitFor;
using testing::HasSubstr;
using testing::Not;

const Vec3 kForce_W_N{0, 1, 0};
const Vec3 kForce_D_N = glm::conjugate(kFacingPatient) * kForce_W_N;

/// Collects all messages until one contains `text`.
bool AwaitMessage(const Served& served, const std::string& text, std::string& said) {
  return WaitFor([&] {
    said += served.Messages();
    return said.find(text) != std::string::npos;
  });
}

std::size_t Count(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
  return count;
}

TEST(DeviceServoAgain, ReasonForAFailedOpeningIsReportedOnce) {
  const auto device = std::make_shared<ReportedDevice>();
  std::atomic<int> tries{0};
  const DeviceServo::Open open = [&, reported = test::OpenReported(device)] {
    ++tries;
    return reported();
  };
  DeviceServo servo("reported", open, PatientOptions(), [](const std::string&, double) { return true; });
  std::string said;
  const auto try_often = [&] {
    const int before = tries.load();
    ASSERT_TRUE(WaitFor([&] { return tries.load() >= before + 8; }));
    for (const std::string& message : servo.TakeMessages()) said += message + "\n";
  };
  device->With([](ReportedDevice::State& state) { state.is_there = false; });
  try_often();
  EXPECT_EQ(Count(said, "\n"), 1u) << said;
  EXPECT_THAT(said, HasSubstr("is gone"));
  said.clear();
  device->With([](ReportedDevice::State& state) {
    state.is_there = true;
    state.fails_to_open = "this user may not open it";
  });
  try_often();
  try_often();
  EXPECT_EQ(said, "reported: this user may not open it\n");
  device->With([](ReportedDevice::State& state) { state.fails_to_open.clear(); });
  EXPECT_TRUE(WaitFor([&] { return servo.state() == ServoState::kWaiting; }));
}

TEST(DeviceServoAgain, HomingDeviceIsRestartedAfterALongSilence) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.1;
  options.restart_after_s = 0.3;
  Served served(options);
  served.Engage({}, {});
  ASSERT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
  // The device has lost power and gets it back, so it must be homed again.
  served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
  std::string said;
  ASSERT_TRUE(AwaitMessage(served, "being restarted", said));
  EXPECT_THAT(said, Not(HasSubstr("is gone")));
  served.device->With([](ReportedDevice::State& state) {
    state.end = RoundEnd::kSample;
    state.sample.homed = false;
    state.largest_N = 0;
  });
  ASSERT_TRUE(WaitFor([&] {
    served.Tick(kForce_W_N);
    return served.servo->state() == ServoState::kHoming;
  }));
  EXPECT_GE(served.device->Look().opened, 2);
  EXPECT_GE(served.device->Look().stopped, 1);
  ASSERT_TRUE(AwaitMessage(served, "pull it out", said));
  served.servo->Agree();  // too early: not homed yet
  served.device->PassRounds(20);
  served.device->With([](ReportedDevice::State& state) { state.sample.homed = true; });
  ASSERT_TRUE(served.Await(ServoState::kWaiting));
  for (int i = 0; i < 20; ++i) {
    served.Tick(kForce_W_N);
    served.device->PassRounds(1);
  }
  EXPECT_EQ(served.servo->state(), ServoState::kWaiting);
  EXPECT_EQ(served.device->Look().largest_N, 0);
  served.servo->Agree();
  EXPECT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
}

TEST(DeviceServoAgain, DeviceThatDoesNotHomeIsNotRestarted) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.05;
  options.restart_after_s = 0.1;
  Served served(options, [](ReportedDevice::State& state) {
    state.traits.homes = false;
    state.traits.homing = "hold the arm in its zero pose";
    state.traits.buttons.clear();
  });
  served.Engage({}, {});
  served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
  ASSERT_TRUE(served.Await(ServoState::kSilent));
  served.device->PassRounds(300);  // each round takes at least a millisecond
  EXPECT_EQ(served.servo->state(), ServoState::kSilent);
  EXPECT_EQ(served.device->Look().opened, 1);
}

TEST(DeviceServoAgain, UserIsInformedHowTheZeroIsTaken) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    state.traits.homes = false;
    state.traits.homing = "hold the arm in its zero pose";
    state.traits.buttons.clear();
  });
  std::string said;
  ASSERT_TRUE(AwaitMessage(served, "reported: hold the arm in its zero pose", said));
  served.Engage({}, {});
  served.device->With([](ReportedDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(AwaitMessage(served, "is gone", said));
  said.clear();
  served.device->With([](ReportedDevice::State& state) { state.is_there = true; });
  ASSERT_TRUE(AwaitMessage(served, "is connected again; agree here", said));  // it has no button to press
  EXPECT_THAT(said, HasSubstr("reported: hold the arm in its zero pose"));
}

TEST(DeviceServoAgain, UnreadyDeviceThatDoesNotHomeIsReported) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    state.traits.homes = false;
    state.traits.homing.clear();
    state.sample.homed = false;  // like a bridge whose motors are off
  });
  std::string said;
  EXPECT_TRUE(AwaitMessage(served, "reported: switch its motors on", said));
  EXPECT_EQ(served.servo->state(), ServoState::kHoming);
}

TEST(DeviceServoAgain, CountsAreCompleteAtEachChangeOfStateAndAfterUnplugging) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.05;
  Served served(options);
  served.Engage({}, {});
  for (int i = 1; i <= 3; ++i) {
    // Only this thread reads the counts, and it waits; the counts must be complete when the state changes.
    served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
    ASSERT_TRUE(served.Await(ServoState::kSilent));
    // There are more if the machine stalls.
    EXPECT_GE(served.servo->counts().rounds.silences, static_cast<std::uint64_t>(i));
    served.device->With([](ReportedDevice::State& state) { state.end = RoundEnd::kSample; });
    ASSERT_TRUE(served.Await(ServoState::kEngaged));
  }
  served.device->PassRounds(7);
  served.device->With([](ReportedDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(served.Await(ServoState::kClosed));
  // Counts every round from the start, including the one in which the device was unplugged.
  EXPECT_EQ(served.servo->counts().rounds.rounds, served.device->Look().rounds);
}

TEST(DeviceServoAgain, UnexpectedExceptionIsTreatedAsUnplugging) {
  const auto device = std::make_shared<ReportedDevice>();
  std::atomic<bool> throws{false};
  std::atomic<int> thrown{0};
  const DeviceServo::Open open = [&, reported = test::OpenReported(device)] {
    if (throws.load()) {
      ++thrown;
      throw 42;  // not an exception that the interface documents
    }
    return reported();
  };
  DeviceServo servo("reported", open, PatientOptions(), [](const std::string&, double) { return true; });
  ASSERT_TRUE(WaitFor([&] { return servo.state() == ServoState::kWaiting; }));
  throws.store(true);
  device->With([](ReportedDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(WaitFor([&] { return thrown.load() >= 4; }));
  std::string said;
  for (const std::string& message : servo.TakeMessages()) said += message + "\n";
  EXPECT_EQ(Count(said, "has failed"), 1u) << said;
  EXPECT_EQ(servo.state(), ServoState::kClosed);
  servo.Agree();  // has no effect, because no device is open
  device->With([](ReportedDevice::State& state) { state.is_there = true; });
  throws.store(false);
  ASSERT_TRUE(WaitFor([&] { return servo.state() == ServoState::kWaiting; }));
  ASSERT_TRUE(device->PassRounds(20));
  EXPECT_EQ(servo.state(), ServoState::kWaiting);
  EXPECT_EQ(device->Look().opened, 2);
}

TEST(DeviceServoAgain, ItsOwnThreadReleasesWithoutWaitingForItself) {
  std::atomic<int> answer{-1};
  Served served;
  served.Engage({}, {});
  ASSERT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
  served.device->With([&](ReportedDevice::State& state) {
    state.on_force = [&](ReportedDevice::State& /*s*/) {  // like a handler of abort(), in the middle of a round
      if (answer.load() < 0) answer = DeviceServo::ReleaseAll(60'000, false) ? 1 : 0;
    };
  });
  ASSERT_TRUE(WaitFor([&] { return answer.load() >= 0; }));  // waits only half as long
  EXPECT_EQ(answer.load(), 0);                               // the force is not off yet
  ASSERT_TRUE(served.TickUntil(kForce_W_N, [&] { return served.servo->state() == ServoState::kWaiting; }));
  EXPECT_EQ(served.device->Look().reported.f_D_N, Vec3(0));
  // From another thread the call waits until the force is off.
  served.servo->Agree();
  ASSERT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
  EXPECT_TRUE(DeviceServo::ReleaseAll(60'000, false));
  EXPECT_EQ(served.device->Look().reported.f_D_N, Vec3(0));
}

TEST(DeviceServoAgain, CapMovesNothingWhileTheDeviceDoesNotAnswer) {
  DeviceServoOptions options = PatientOptions();
  options.max_sample_age_s = 0.2;
  Served served(options, [](ReportedDevice::State& state) {
    state.traits.motion = DriverMotion::kDeflection;
    state.traits.makes_force = false;
    state.traits.homes = false;
    state.sample.deflection = {0.5, 0, 0, 0, 0, 0};
  });
  ASSERT_TRUE(WaitFor([&] { return served.servo->ReadDeflection()[0] == 0.5; }));
  // From here on, the device's round does not return.
  served.device->With(
      [&](ReportedDevice::State&) { EXPECT_TRUE(WaitFor([&] { return served.servo->ReadDeflection()[0] == 0; })); });
  EXPECT_TRUE(WaitFor([&] { return served.servo->ReadDeflection()[0] == 0.5; }));
}

}  // namespace
}  // namespace kerf
