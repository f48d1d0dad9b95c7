// The rounds with a device: force only where it is allowed, and no force after any fault.
#include "device/devices/servo_round.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "base/core/heap_guard.h"
#include "device/devices/falcon/falcon_driver.h"
#include "device/devices/hid/wooden_driver.h"
#include "device/devices/profiles.h"
#include "device/emulation/falcon_model.h"
#include "device/emulation/model_bus.h"
#include "device/emulation/scripted_hand.h"
#include "device/emulation/wooden_model.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr double kRound_s = 0.001;
constexpr double kForce_N = 2;
// A motor count is 0.1 N mm at a joint, and 1 N at the grip is about 40 to 60 N mm: one count is at most 3 mN there,
// and one count of each of the three motors together is at most 5 mN.
constexpr double kMotorCount_N = 0.005;

/// A device whose behaviour the test defines.
class ReportedDriver final : public DeviceDriver {
 public:
  explicit ReportedDriver(bool senses_orientation = false) {
    traits_.homes = true;
    traits_.senses_orientation = senses_orientation;
  }
  const DeviceProfile& profile() const override { return FindDeviceProfile("falcon"); }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string&, double)>&) override {}
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override {
    reported = command;
    if (end == RoundEnd::kSample) sample = next;
    return end;
  }
  void Stop() noexcept override {}

  RoundEnd end = RoundEnd::kSample;
  DriverSample next;
  DriverCommand reported;

 private:
  DriverTraits traits_;
};

/// Runs rounds at 1 kHz with a force requested by a simulation that runs at the same rate.
class Rounds {
 public:
  explicit Rounds(const DriverTraits& traits) : round(FindDeviceProfile("falcon"), traits, {}) { round.Open(now_s); }

  /// Returns the largest force that was sent.
  double Run(DeviceDriver& driver, double seconds, bool agrees = false) {
    double largest_N = 0;
    for (double t_s = 0; t_s < seconds; t_s += kRound_s) {
      now_s += kRound_s;
      command.made_at_s = now_s;
      ++command.sequence;
      command.command.f_D_N = {0, 0, kForce_N};
      round.Step(driver, now_s, kRound_s, command, agrees);
      agrees = false;
      const double sent_N = glm::length(round.sent_force_N());
      largest_N = std::max(largest_N, sent_N);
      largest_rise_N = std::max(largest_rise_N, sent_N - last_N_);
      last_N_ = sent_N;
    }
    return largest_N;
  }

  ServoRound round;
  ServoCommand command;
  double now_s = 10;
  double largest_rise_N = 0;

 private:
  double last_N_ = 0;
};

TEST(ServoRound, OutputsNoForceBeforeHomingAndAgreement) {
  ReportedDriver driver;
  driver.next.homed = false;
  Rounds rounds(driver.traits());
  EXPECT_EQ(rounds.Run(driver, 2, true), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kHoming);
  driver.next.homed = true;
  EXPECT_EQ(rounds.Run(driver, 2), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
  rounds.Run(driver, 2, true);
  EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
  EXPECT_DOUBLE_EQ(rounds.Run(driver, 0.1), kForce_N);
  EXPECT_TRUE(driver.reported.engaged);
}

TEST(ServoRound, NewlyPressedButtonAgreesAndAHeldOneDoesNot) {
  ReportedDriver driver;
  driver.next.buttons = 4;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 1);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
  driver.next.buttons = 0;
  rounds.Run(driver, 0.1);
  driver.next.buttons = 1;
  rounds.Run(driver, 0.1);
  EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
}

TEST(ServoRound, LosingItsZeroEndsTheForceUntilTheUserAgreesAgain) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 0.1);
  rounds.Run(driver, 2, true);
  ASSERT_EQ(rounds.round.state(), ServoState::kEngaged);
  driver.next.homed = false;
  rounds.Run(driver, 0.1);  // the ramp to zero takes 20 ms
  EXPECT_EQ(rounds.Run(driver, 1), 0);
  driver.next.homed = true;
  EXPECT_EQ(rounds.Run(driver, 1), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
}

TEST(ServoRound, LongSilenceRequiresNewAgreementAndAShortOneDoesNot) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 0.1);
  rounds.Run(driver, 2, true);
  driver.end = RoundEnd::kNoAnswer;
  rounds.Run(driver, 0.2);
  EXPECT_EQ(rounds.round.state(), ServoState::kSilent);
  EXPECT_EQ(glm::length(driver.reported.f_D_N), 0);
  driver.end = RoundEnd::kSample;
  rounds.Run(driver, 2);
  EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
  EXPECT_EQ(rounds.round.sample().engagements, 2u);  // the handle may be at a different place
  EXPECT_DOUBLE_EQ(glm::length(driver.reported.f_D_N), kForce_N);
  driver.end = RoundEnd::kBadAnswer;
  rounds.Run(driver, 1);
  driver.end = RoundEnd::kSample;
  EXPECT_EQ(rounds.Run(driver, 1), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
  EXPECT_EQ(rounds.round.counts().silences, 2u);
}

TEST(ServoRound, LongPauseBetweenRoundsRequiresNewAgreement) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 0.1);
  rounds.Run(driver, 2, true);
  ASSERT_EQ(rounds.round.state(), ServoState::kEngaged);
  // After 0.3 s without a round, the device counts as silent for one round; then the handle takes the tool again.
  rounds.now_s += 0.3;
  rounds.command.made_at_s = rounds.now_s;
  ++rounds.command.sequence;
  EXPECT_EQ(rounds.round.Step(driver, rounds.now_s, 0.3, rounds.command, false), ServoState::kSilent);
  rounds.Run(driver, 0.01);
  EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
  EXPECT_EQ(rounds.round.sample().engagements, 2u);
  // After a minute, the user must agree again.
  rounds.now_s += 60;
  rounds.command.made_at_s = rounds.now_s;
  ++rounds.command.sequence;
  rounds.round.Step(driver, rounds.now_s, 60, rounds.command, false);
  rounds.Run(driver, 0.05);  // the ramp to zero takes 20 ms
  EXPECT_EQ(rounds.Run(driver, 2), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
}

TEST(ServoRound, JumpIsNotAccepted) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 0.1);
  rounds.Run(driver, 2, true);
  // 4 m/s is a fast hand.
  for (int i = 0; i < 20; ++i) {
    driver.next.X_DH.p_AB.x += 4;
    rounds.Run(driver, 0.5 * kRound_s);
  }
  EXPECT_EQ(rounds.round.counts().jumps, 0u);
  EXPECT_EQ(rounds.round.sample().engagements, 1u);
  driver.next.X_DH.p_AB.x += 12;
  rounds.Run(driver, 0.5 * kRound_s);
  EXPECT_EQ(rounds.round.state(), ServoState::kSilent);
  rounds.Run(driver, 0.03);
  EXPECT_EQ(rounds.round.counts().jumps, 1u);
  EXPECT_EQ(rounds.round.sample().engagements, 2u);
  EXPECT_EQ(glm::length(driver.reported.f_D_N), 0);  // the force starts again from zero
  EXPECT_DOUBLE_EQ(rounds.Run(driver, 2), kForce_N);
}

TEST(ServoRound, LettingGoEndsTheForceInTheNextRound) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 0.1);
  rounds.Run(driver, 2, true);
  ASSERT_GT(glm::length(driver.reported.f_D_N), 0);
  rounds.round.Release();
  EXPECT_EQ(rounds.Run(driver, 2), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
}

TEST(ServoRound, AllocatesNothing) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.Run(driver, 0.1);
  const HeapGuard guard;
  rounds.Run(driver, 0.5, true);
  driver.end = RoundEnd::kBadAnswer;
  rounds.Run(driver, 0.2);
}

TEST(ServoRound, FieldIsScaledLikeTheForce) {
  ReportedDriver driver;
  Rounds rounds(driver.traits());
  rounds.command.command.stiffness_N_per_mm = 3;
  rounds.Run(driver, 0.1);
  EXPECT_EQ(driver.reported.stiffness_N_per_mm, 0);
  rounds.Run(driver, 0.35, true);  // to the middle of the ramp
  const double fraction = driver.reported.f_D_N.z / kForce_N;
  ASSERT_GT(fraction, 0.1);
  ASSERT_LT(fraction, 0.9);
  EXPECT_NEAR(driver.reported.stiffness_N_per_mm, 3 * fraction, 1e-12);
  rounds.Run(driver, 1);
  EXPECT_DOUBLE_EQ(driver.reported.stiffness_N_per_mm, 3);
}

/// A Falcon within the process, held by a hand.
class FalconOnABus {
 public:
  FalconOnABus() : hand_(FindDeviceProfile("falcon"), FindHandModel("H3"), {}), model_(hand_, {}) {
    bus.PlugIn(model_);
  }
  void Open() {
    FalconOptions options;
    options.firmware.assign(2000, 0x5a);
    driver = std::make_unique<FalconDriver>(bus.Open(bus.List().at(0), 0).transport, options);
    driver->Start([](const std::string&, double) { return true; });
  }
  ScriptedHand& hand() { return hand_; }
  FalconModel& model() { return model_; }

 private:
  // These must outlive the driver, whose end sends a last command to the device.
  ScriptedHand hand_;
  FalconModel model_;

 public:
  ModelBus bus;
  std::unique_ptr<FalconDriver> driver;
};

/// Driver that advances time with each round, as a real device does.
class WithTime final : public DeviceDriver {
 public:
  explicit WithTime(FalconOnABus& falcon) : falcon_(falcon) {}
  const DeviceProfile& profile() const override { return falcon_.driver->profile(); }
  const DriverTraits& traits() const override { return falcon_.driver->traits(); }
  void Start(const std::function<bool(const std::string&, double)>&) override {}
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override {
    falcon_.bus.Advance(kRound_s);
    return falcon_.driver->Exchange(command, sample);
  }
  void Stop() noexcept override { falcon_.driver->Stop(); }

 private:
  FalconOnABus& falcon_;
};

TEST(ServoRound, FalconHomesOutputsForceAndIsUnplugged) {
  FalconOnABus falcon;
  falcon.Open();
  WithTime driver(falcon);
  Rounds rounds(driver.traits());
  EXPECT_EQ(rounds.Run(driver, 1, true), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kHoming);
  falcon.hand().Home();
  EXPECT_EQ(rounds.Run(driver, 4), 0);
  ASSERT_EQ(rounds.round.state(), ServoState::kWaiting);
  rounds.Run(driver, 3, true);
  ASSERT_EQ(rounds.round.state(), ServoState::kEngaged);
  EXPECT_NEAR(falcon.model().f_D_N().z, kForce_N, kMotorCount_N);
  EXPECT_NEAR(falcon.model().f_D_N().x, 0, kMotorCount_N);

  UsbFaults unplugged;
  unplugged.unplugged = true;
  falcon.bus.SetFaults(unplugged);
  rounds.Run(driver, kRound_s);
  EXPECT_EQ(rounds.round.state(), ServoState::kClosed);
  EXPECT_TRUE(falcon.bus.List().empty());

  falcon.bus.PlugInAgain();
  falcon.Open();
  EXPECT_EQ(falcon.model().uploads(), 2);
  rounds.round.Open(rounds.now_s);
  rounds.largest_rise_N = 0;
  EXPECT_EQ(rounds.Run(driver, 1, true), 0);
  falcon.hand().Home();
  EXPECT_EQ(rounds.Run(driver, 4), 0);
  EXPECT_EQ(rounds.round.state(), ServoState::kWaiting);
  rounds.Run(driver, 2, true);
  EXPECT_EQ(rounds.round.sample().engagements, 2u);
  // The steepest slope of a smooth ramp of 0.5 s is 1.5 times its mean slope.
  EXPECT_LE(rounds.largest_rise_N, 1.5 * kForce_N * kRound_s / 0.5 + 1e-9);
}

TEST(ServoRound, ForceStaysWithinBoundsUnderCableFaults) {
  FalconOnABus falcon;
  falcon.Open();
  WithTime driver(falcon);
  Rounds rounds(driver.traits());
  falcon.hand().Home();
  rounds.Run(driver, 4);
  UsbFaults faults;
  faults.drop_in = faults.drop_out = faults.duplicate = faults.truncate = faults.corrupt = faults.delay = 0.05;
  falcon.bus.SetFaults(faults);
  double largest_N = 0;
  for (int i = 0; i < 60'000; ++i) {
    rounds.Run(driver, kRound_s, true);
    const Vec3 f = falcon.model().f_D_N();
    ASSERT_TRUE(std::isfinite(glm::length(f)));
    largest_N = std::max(largest_N, glm::length(f));
  }
  // Packets to the device are lost as a whole: the motors' force was requested for the position known at that time.
  // Since then the hand has moved by a millimetre or two, which changes the legs' leverage by about as many percent.
  EXPECT_LE(largest_N, 1.03 * kForce_N);
  EXPECT_GT(largest_N, 0.5 * kForce_N);  // the force was not zero all the time
}

/// A WoodenHaptics device within the process; each round advances time.
class WoodenOnABus final : public DeviceDriver {
 public:
  WoodenOnABus() : model_(hand, {}) {
    bus.PlugIn(model_);
    driver_ = std::make_unique<WoodenDriver>(bus.Open(bus.List().at(0), 0).transport, WoodenParams{});
    driver_->Start(nullptr);
  }
  const DeviceProfile& profile() const override { return driver_->profile(); }
  const DriverTraits& traits() const override { return driver_->traits(); }
  void Start(const std::function<bool(const std::string&, double)>&) override {}
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override {
    bus.Advance(kRound_s);
    return driver_->Exchange(command, sample);
  }
  void Stop() noexcept override { driver_->Stop(); }

  PrescribedMechanism hand;

 private:
  WoodenModel model_;

 public:
  ModelBus bus;

 private:
  std::unique_ptr<WoodenDriver> driver_;
};

TEST(ServoRound, DeviceThatSendsButDoesNotReceiveIsSilent) {
  constexpr int kShort = 4;
  for (const Transfer ends : {Transfer{TransferEnd::kStall, 0}, Transfer{TransferEnd::kTimeout, 0},
                              Transfer{TransferEnd::kFailed, 0}, Transfer{TransferEnd::kOk, kShort}}) {
    WoodenOnABus device;
    Rounds rounds(device.traits());
    rounds.Run(device, 0.1);
    rounds.Run(device, 2, true);
    ASSERT_EQ(rounds.round.state(), ServoState::kEngaged);
    // Currents are integers in mA and are computed for the lever arm of a few counts ago.
    ASSERT_NEAR(device.hand.f_D_N().z, kForce_N, 0.05);
    const std::uint64_t samples = rounds.round.counts().samples;
    UsbFaults faults;
    faults.out_ends = ends;
    device.bus.SetFaults(faults);
    rounds.Run(device, 0.1);  // 50 ms, and the ramp to zero of 20 ms
    EXPECT_EQ(rounds.round.state(), ServoState::kSilent);
    EXPECT_EQ(rounds.round.counts().samples, samples);
    EXPECT_EQ(glm::length(rounds.round.sent_force_N()), 0);
    // The device receives commands again while its motors still make the last force.
    device.bus.SetFaults({});
    rounds.Run(device, 0.003);
    EXPECT_EQ(device.hand.f_D_N(), Vec3{0});
    rounds.largest_rise_N = 0;
    double largest_rise_N = 0;
    for (int i = 0; i < 2000; ++i) {
      const double before_N = glm::length(device.hand.f_D_N());
      rounds.Run(device, 0.5 * kRound_s);
      largest_rise_N = std::max(largest_rise_N, glm::length(device.hand.f_D_N()) - before_N);
    }
    EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
    EXPECT_EQ(rounds.round.counts().silences, 1u);
    EXPECT_NEAR(device.hand.f_D_N().z, kForce_N, 0.05);
    // The steepest slope of a smooth ramp of 0.5 s is 1.5 times its mean slope; 1 mA in each of three motors is a few
    // mN.
    EXPECT_LE(rounds.largest_rise_N, 1.5 * kForce_N * kRound_s / 0.5 + 1e-9);
    EXPECT_LE(largest_rise_N, 1.5 * kForce_N * kRound_s / 0.5 + 0.01);
  }
}

/// Transport that reports a timeout although the data were sent, as when a transfer is cancelled just before its end.
class DeafLine final : public UsbTransport {
 public:
  DeafLine(std::unique_ptr<UsbTransport> line, const bool& deaf) : line_(std::move(line)), deaf_(deaf) {}
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                   std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    return line_->Control(request_type, request, value, index, data, timeout_ms);
  }
  Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data, int timeout_ms) noexcept override {
    const Transfer transfer = line_->Write(endpoint, data, timeout_ms);
    return deaf_ ? Transfer{TransferEnd::kTimeout, 0} : transfer;
  }
  Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data, int timeout_ms) noexcept override {
    return line_->Read(endpoint, data, timeout_ms);
  }

 private:
  std::unique_ptr<UsbTransport> line_;
  const bool& deaf_;
};

TEST(ServoRound, FalconThatSendsButDoesNotReceiveIsSilent) {
  FalconOnABus falcon;
  bool deaf = false;
  FalconOptions options;
  options.firmware.assign(2000, 0x5a);
  falcon.driver = std::make_unique<FalconDriver>(
      std::make_unique<DeafLine>(falcon.bus.Open(falcon.bus.List().at(0), 0).transport, deaf), options);
  falcon.driver->Start(nullptr);
  WithTime driver(falcon);
  Rounds rounds(driver.traits());
  falcon.hand().Home();
  rounds.Run(driver, 5);
  rounds.Run(driver, 2, true);
  ASSERT_EQ(rounds.round.state(), ServoState::kEngaged);
  deaf = true;
  rounds.Run(driver, 0.1);
  EXPECT_EQ(rounds.round.state(), ServoState::kSilent);
  EXPECT_EQ(glm::length(rounds.round.sent_force_N()), 0);
  deaf = false;
  rounds.largest_rise_N = 0;
  rounds.Run(driver, 2);
  EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
  EXPECT_EQ(rounds.round.counts().silences, 1u);
  EXPECT_LE(rounds.largest_rise_N, 1.5 * kForce_N * kRound_s / 0.5 + 1e-9);
}

TEST(ServoRound, RotationJumpIsNotAcceptedIfOrientationIsSensed) {
  const auto turned = [](double angle_rad, const Vec3& axis) {
    return Quat(std::cos(angle_rad / 2), std::sin(angle_rad / 2) * axis);
  };
  const Vec3 axis(0.6, 0, -0.8);
  for (const bool senses : {true, false}) {
    ReportedDriver driver(senses);
    Rounds rounds(driver.traits());
    rounds.Run(driver, 0.1);
    rounds.Run(driver, 2, true);
    // 25 rad/s is a fast hand, which is also accepted over more than one full turn; both signs of the quaternion are
    // the same rotation.
    double angle_rad = 0;
    for (int i = 0; i < 600; ++i) {
      angle_rad += 0.025;
      driver.next.X_DH.R_AB = (i % 2 == 0 ? 1.0 : -1.0) * turned(angle_rad, axis);
      rounds.Run(driver, 0.5 * kRound_s);
    }
    EXPECT_EQ(rounds.round.counts().jumps, 0u);
    EXPECT_EQ(rounds.round.sample().engagements, 1u);
    // A jump, as when a grip drops out and is reported as unrotated. The limit is 0.1 rad plus 30 rad/s over 1 ms, 0.13
    // rad.
    driver.next.X_DH.R_AB = turned(angle_rad + 0.14, axis);
    rounds.Run(driver, 0.5 * kRound_s);
    if (!senses) {
      EXPECT_EQ(rounds.round.counts().jumps, 0u);
      EXPECT_EQ(rounds.round.state(), ServoState::kEngaged);
      continue;
    }
    EXPECT_EQ(rounds.round.state(), ServoState::kSilent);
    rounds.Run(driver, 0.03);
    EXPECT_EQ(rounds.round.counts().jumps, 1u);
    EXPECT_EQ(rounds.round.sample().engagements, 2u);
    EXPECT_EQ(glm::length(driver.reported.f_D_N), 0);
    EXPECT_DOUBLE_EQ(rounds.Run(driver, 2), kForce_N);
    EXPECT_EQ(rounds.round.counts().jumps, 1u);
  }
}

TEST(ServoRound, RefusesBoundsOutOfRange) {
  ReportedDriver driver(true);
  for (const double bad : {0.9, 2e9, std::nan("")}) {
    ServoParams params;
    params.max_speed_rad_per_s = bad;
    EXPECT_THROW(ServoRound(driver.profile(), driver.traits(), params), Error) << bad;
  }
}

}  // namespace
}  // namespace kerf
