// A device that went away and comes again, or that must be made ready by hand first: what is said, and that nothing is
// made of it before the user has agreed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "device/drivers/device_servo.h"
#include "device/drivers/told_device.h"

namespace kerf {
namespace {

using test::PatientOptions;
using test::Served;
using test::ToldDevice;
using test::WaitFor;
using testing::HasSubstr;
using testing::Not;

const Vec3 kForce_W_N{0, 1, 0};
const Vec3 kForce_D_N = glm::conjugate(kFacingPatient) * kForce_W_N;

/// All that was said, until a text is among it.
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

TEST(DeviceServoAgain, WhyItMayNotBeOpenedIsSaidOnce) {
  const auto device = std::make_shared<ToldDevice>();
  std::atomic<int> tries{0};
  const DeviceServo::Open open = [&, told = test::OpenTold(device)] {
    ++tries;
    return told();
  };
  DeviceServo servo("told", open, PatientOptions(), [](const std::string&, double) { return true; });
  std::string said;
  const auto try_often = [&] {
    const int before = tries.load();
    ASSERT_TRUE(WaitFor([&] { return tries.load() >= before + 8; }));
    for (const std::string& message : servo.TakeMessages()) said += message + "\n";
  };
  device->With([](ToldDevice::State& state) { state.is_there = false; });
  try_often();
  EXPECT_EQ(Count(said, "\n"), 1u) << said;
  EXPECT_THAT(said, HasSubstr("is gone"));
  said.clear();
  device->With([](ToldDevice::State& state) {
    state.is_there = true;
    state.fails_to_open = "this user may not open it";
  });
  try_often();
  try_often();
  EXPECT_EQ(said, "told: this user may not open it\n");
  device->With([](ToldDevice::State& state) { state.fails_to_open.clear(); });
  EXPECT_TRUE(WaitFor([&] { return servo.state() == ServoState::kWaiting; }));
}

TEST(DeviceServoAgain, OneThatHomesIsStartedAnewWhenItHasNotAnsweredForLong) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.1;
  options.given_up_s = 0.3;
  Served served(options);
  served.Engage({}, {});
  ASSERT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
  // Its power has been pulled, and comes back: it must be homed again.
  served.device->With([](ToldDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
  std::string said;
  ASSERT_TRUE(AwaitMessage(served, "started anew", said));
  EXPECT_THAT(said, Not(HasSubstr("is gone")));
  served.device->With([](ToldDevice::State& state) {
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
  served.servo->Agree();  // too early
  served.device->PassRounds(20);
  served.device->With([](ToldDevice::State& state) { state.sample.homed = true; });
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

TEST(DeviceServoAgain, OneThatTakesItsZeroWhereItIsIsNot) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.05;
  options.given_up_s = 0.1;
  Served served(options, [](ToldDevice::State& state) {
    state.traits.homes = false;
    state.traits.homing = "hold the arm in its zero pose";
    state.traits.buttons.clear();
  });
  served.Engage({}, {});
  served.device->With([](ToldDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
  ASSERT_TRUE(served.Await(ServoState::kSilent));
  served.device->PassRounds(300);  // a millisecond each, or more
  EXPECT_EQ(served.servo->state(), ServoState::kSilent);
  EXPECT_EQ(served.device->Look().opened, 1);
}

TEST(DeviceServoAgain, TheUserHearsHowItsZeroIsTaken) {
  Served served(PatientOptions(), [](ToldDevice::State& state) {
    state.traits.homes = false;
    state.traits.homing = "hold the arm in its zero pose";
    state.traits.buttons.clear();
  });
  std::string said;
  ASSERT_TRUE(AwaitMessage(served, "told: hold the arm in its zero pose", said));
  served.Engage({}, {});
  served.device->With([](ToldDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(AwaitMessage(served, "is gone", said));
  said.clear();
  served.device->With([](ToldDevice::State& state) { state.is_there = true; });
  ASSERT_TRUE(AwaitMessage(served, "is there again; agree here", said));  // there is no button to press
  EXPECT_THAT(said, HasSubstr("told: hold the arm in its zero pose"));
}

TEST(DeviceServoAgain, OneThatIsNotReadySaysSoThoughItDoesNotHome) {
  Served served(PatientOptions(), [](ToldDevice::State& state) {
    state.traits.homes = false;
    state.traits.homing.clear();
    state.sample.homed = false;  // a bridge whose motors are off
  });
  std::string said;
  EXPECT_TRUE(AwaitMessage(served, "told: switch its motors on", said));
  EXPECT_EQ(served.servo->state(), ServoState::kHoming);
}

TEST(DeviceServoAgain, WhatIsCountedIsWholeAtEachChangeOfStateAndWhenItIsGone) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = 0.05;
  Served served(options);
  served.Engage({}, {});
  for (int i = 1; i <= 3; ++i) {
    // Nobody reads them but this thread, and it waits: each is there with the state that it belongs to.
    served.device->With([](ToldDevice::State& state) { state.end = RoundEnd::kNoAnswer; });
    ASSERT_TRUE(served.Await(ServoState::kSilent));
    // A machine that stands still makes more.
    EXPECT_GE(served.servo->counts().rounds.silences, static_cast<std::uint64_t>(i));
    served.device->With([](ToldDevice::State& state) { state.end = RoundEnd::kSample; });
    ASSERT_TRUE(served.Await(ServoState::kEngaged));
  }
  served.device->PassRounds(7);
  served.device->With([](ToldDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(served.Await(ServoState::kClosed));
  // Each round since the beginning, the one in which it was gone included.
  EXPECT_EQ(served.servo->counts().rounds.rounds, served.device->Look().rounds);
}

TEST(DeviceServoAgain, AFaultNobodyForesawIsLikeAnUnplugAndEndsNothing) {
  const auto device = std::make_shared<ToldDevice>();
  std::atomic<bool> throws{false};
  std::atomic<int> thrown{0};
  const DeviceServo::Open open = [&, told = test::OpenTold(device)] {
    if (throws.load()) {
      ++thrown;
      throw 42;  // what it throws is told by nobody's contract
    }
    return told();
  };
  DeviceServo servo("told", open, PatientOptions(), [](const std::string&, double) { return true; });
  ASSERT_TRUE(WaitFor([&] { return servo.state() == ServoState::kWaiting; }));
  throws.store(true);
  device->With([](ToldDevice::State& state) { state.is_there = false; });
  ASSERT_TRUE(WaitFor([&] { return thrown.load() >= 4; }));
  std::string said;
  for (const std::string& message : servo.TakeMessages()) said += message + "\n";
  EXPECT_EQ(Count(said, "has failed"), 1u) << said;
  EXPECT_EQ(servo.state(), ServoState::kClosed);
  servo.Agree();  // to nothing
  device->With([](ToldDevice::State& state) { state.is_there = true; });
  throws.store(false);
  ASSERT_TRUE(WaitFor([&] { return servo.state() == ServoState::kWaiting; }));
  ASSERT_TRUE(device->PassRounds(20));
  EXPECT_EQ(servo.state(), ServoState::kWaiting);
  EXPECT_EQ(device->Look().opened, 2);
}

TEST(DeviceServoAgain, ItsOwnThreadLetsGoWithoutWaitingForItself) {
  std::atomic<int> answer{-1};
  Served served;
  served.Engage({}, {});
  ASSERT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
  served.device->With([&](ToldDevice::State& state) {
    state.feels = [&](ToldDevice::State& /*s*/) {  // as a handler of abort() would, in mid-round
      if (answer.load() < 0) answer = DeviceServo::LetGoOfAll(60'000, false) ? 1 : 0;
    };
  });
  ASSERT_TRUE(WaitFor([&] { return answer.load() >= 0; }));  // half as long
  EXPECT_EQ(answer.load(), 0);                               // it has not let go yet
  ASSERT_TRUE(served.TickUntil(kForce_W_N, [&] { return served.servo->state() == ServoState::kWaiting; }));
  EXPECT_EQ(served.device->Look().told.f_D_N, Vec3(0));
  // From another thread it waits for that.
  served.servo->Agree();
  ASSERT_TRUE(served.AwaitForce(kForce_W_N, kForce_D_N));
  EXPECT_TRUE(DeviceServo::LetGoOfAll(60'000, false));
  EXPECT_EQ(served.device->Look().told.f_D_N, Vec3(0));
}

TEST(DeviceServoAgain, ACapThatIsNotHeardMovesNothing) {
  DeviceServoOptions options = PatientOptions();
  options.old_s = 0.2;
  Served served(options, [](ToldDevice::State& state) {
    state.traits.motion = DriverMotion::kDeflection;
    state.traits.makes_force = false;
    state.traits.homes = false;
    state.sample.deflection = {0.5, 0, 0, 0, 0, 0};
  });
  ASSERT_TRUE(WaitFor([&] { return served.servo->ReadDeflection()[0] == 0.5; }));
  // Its round does not come back.
  served.device->With(
      [&](ToldDevice::State&) { EXPECT_TRUE(WaitFor([&] { return served.servo->ReadDeflection()[0] == 0; })); });
  EXPECT_TRUE(WaitFor([&] { return served.servo->ReadDeflection()[0] == 0.5; }));
}

}  // namespace
}  // namespace kerf
