// Tests of how the window uses a device: the effect of button presses, and the wanted pose of the saw.
#include "app/window/hand_device.h"

#include <gtest/gtest.h>

#include "device/drivers/reported_device.h"

namespace kerf {
namespace {

using test::PatientOptions;
using test::ReportedDevice;
using test::WaitFor;

constexpr std::uint32_t kSpindle = 2;
// Right is the world's y, up is z, and towards the user is x.
const ViewBasis kView{.right_W = {0, 1, 0}, .up_W = {0, 0, 1}, .forward_W = {-1, 0, 0}, .mm_per_pixel = 0.1};

class HandDeviceTest : public testing::Test {
 protected:
  void Open(const std::function<void(ReportedDevice::State&)>& prepare = {}) {
    if (prepare) reported->With(prepare);
    DeviceServoOptions options = PatientOptions();
    options.reported_orientation = true;  // as in the window
    servo = std::make_shared<DeviceServo>("reported", test::OpenReported(reported), options,
                                          [](const std::string&, double) { return true; });
    hand.emplace(servo);
    servo->SetTool(X_WT, {});
    ASSERT_TRUE(WaitFor([&] {
      const ServoState state = servo->state();
      return state == ServoState::kWaiting || (state == ServoState::kEngaged && !servo->traits().makes_force);
    }));
  }
  HandDeviceFrame Frame(std::uint32_t buttons) {
    reported->With([&](ReportedDevice::State& state) { state.sample.buttons = buttons; });
    EXPECT_TRUE(reported->PassRounds());
    return hand->Update(0.1, kView, X_WT, controls);
  }

  std::shared_ptr<ReportedDevice> reported = std::make_shared<ReportedDevice>();
  std::shared_ptr<DeviceServo> servo;
  std::optional<HandDevice> hand;
  Pose X_WT{{1, 0, 0, 0}, {10, 20, 30}};
  SawControls controls{Pose{}};
};

TEST_F(HandDeviceTest, ConfirmingPressDoesNotSwitchTheSpindle) {
  Open();
  EXPECT_FALSE(Frame(0).switches_spindle);
  EXPECT_FALSE(Frame(kSpindle).switches_spindle);
  EXPECT_EQ(servo->state(), ServoState::kEngaged);
  EXPECT_FALSE(Frame(kSpindle).switches_spindle);
  EXPECT_FALSE(Frame(0).switches_spindle);
  EXPECT_TRUE(Frame(kSpindle).switches_spindle);
  EXPECT_FALSE(Frame(kSpindle).switches_spindle);  // once per press
}

TEST_F(HandDeviceTest, HandleMovesTheSawInViewDirections) {
  Open();
  EXPECT_TRUE(hand->holds());
  EXPECT_TRUE(hand->waits());
  Frame(0);
  EXPECT_EQ(controls.wanted().p_AB, X_WT.p_AB);
  hand->Agree();
  ASSERT_TRUE(WaitFor([&] { return servo->state() == ServoState::kEngaged; }));
  Frame(0);
  DeviceSample sample;
  ASSERT_TRUE(servo->Read(sample));
  reported->With([](ReportedDevice::State& state) { state.sample.X_DH.p_AB = {3, 5, 7}; });
  ASSERT_TRUE(reported->PassRounds());
  ASSERT_TRUE(servo->Read(sample));
  EXPECT_LE(glm::length(sample.X_WH.p_AB - X_WT.p_AB - Vec3(7, 3, 5)), 1e-9);
}

TEST_F(HandDeviceTest, CapMovesTheWantedPoseWithoutConfirmation) {
  Open([](ReportedDevice::State& state) {
    state.traits.makes_force = false;
    state.traits.motion = DriverMotion::kDeflection;
    state.sample.deflection = {0, 1, 0, 0, 0, 0};
  });
  EXPECT_FALSE(hand->holds());
  ASSERT_TRUE(WaitFor([&] {
    Frame(0);
    return servo->state() == ServoState::kEngaged;
  }));
  const Vec3 before = controls.wanted().p_AB;
  Frame(0);
  EXPECT_LE(glm::length(controls.wanted().p_AB - before - Vec3(0, 0, 0.1 * DeflectionSpeeds{}.mm_per_s)), 1e-9);
}

}  // namespace
}  // namespace kerf
