// The device check: it gets the right results for a known device and never exceeds its limits.
#include "device/drivers/device_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "device/devices/falcon/falcon_driver.h"
#include "device/devices/falcon/falcon_usb.h"
#include "device/drivers/reported_device.h"
#include "device/emulation/falcon_model.h"
#include "device/emulation/model_bus.h"
#include "device/emulation/scripted_hand.h"
#include "support/stall_detector.h"

namespace kerf {
namespace {

using test::LongestGap;
using test::PatientOptions;
using test::ReportedDevice;
using test::RetryIfStalled;
using test::Served;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kQuantum_mm = 0.04;
constexpr double kSpring_N_per_mm = 0.5;

/// Moves a handle on a spring, with a quantised position; at rest, the position alternates between two neighbouring
/// steps.
void MoveOnSpring(ReportedDevice::State& state) {
  Vec3 p_mm = state.reported.f_D_N / kSpring_N_per_mm;
  p_mm.y += state.rounds / 3 % 2 == 0 ? kQuantum_mm : 0;
  state.sample.X_DH.p_AB = kQuantum_mm * glm::round(p_mm / kQuantum_mm);
}

DeviceCheckOptions ShortOptions() {
  DeviceCheckOptions options;
  options.homing_s = 60;
  options.still_s = 2;     // at least 100 samples are required in this time, of which the device makes up to 2000
  options.circle_s = 4;    // includes two seconds at full force: enough for the gate to reopen after a stall
  options.buttons_s = 20;  // at most; it ends when all buttons have been pressed
  return options;
}

double FalconPeakForce() {
  return FindDeviceProfile("falcon").peak_force_N;
}

TEST(DeviceCheck, MeasuresAKnownDevice) {
  // The check needs two seconds at rest and two at full force; if the machine stalls for half of either, there is no
  // result.
  RetryIfStalled(std::chrono::milliseconds(1000), [](LongestGap& own) {
    Served served(PatientOptions(), [](ReportedDevice::State& state) { state.on_force = MoveOnSpring; });
    DeviceCheckOptions options = ShortOptions();
    options.goes_on = [&] {
      own.Look();
      return true;
    };
    std::string said;
    options.say = [&](const std::string& text) {
      said += text + "\n";
      if (text.starts_with("press each button")) {
        served.device->With([](ReportedDevice::State& state) { state.sample.buttons = 0b1011; });
      } else if (text == "button left") {
        served.device->With([](ReportedDevice::State& state) { state.sample.buttons = 0b0100; });
      }
    };
    const DeviceCheckResult r = CheckDevice(*served.servo, options);
    EXPECT_THAT(r.faults, IsEmpty());
    EXPECT_TRUE(r.homed);
    EXPECT_FALSE(r.stopped);
    EXPECT_GT(r.still_samples, 15U);
    EXPECT_NEAR(r.least_step_mm, kQuantum_mm, 1e-9);
    EXPECT_NEAR(r.span_mm.y, kQuantum_mm, 1e-9);
    EXPECT_EQ(r.span_mm.x, 0);
    // Both values occur equally often; samples that are skipped by chance make the ratio less even.
    EXPECT_GT(r.noise_mm.y, 0.2 * kQuantum_mm);
    EXPECT_LE(r.noise_mm.y, 0.5 * kQuantum_mm + 1e-9);
    EXPECT_TRUE(r.made_force);
    EXPECT_NEAR(r.largest_requested_N, 0.2 * FalconPeakForce(), 1e-9);
    EXPECT_NEAR(r.largest_sent_N, 0.2 * FalconPeakForce(), 0.03 * 0.2 * FalconPeakForce());
    EXPECT_LE(served.device->Look().largest_N, 0.2 * FalconPeakForce() + 1e-9);
    EXPECT_NEAR(r.moved_mm, 0.2 * FalconPeakForce() / kSpring_N_per_mm, 0.1);
    EXPECT_GT(r.followed, 0.9);
    EXPECT_EQ(r.buttons, 0b1111U);
    EXPECT_THAT(said, HasSubstr("leave the handle alone"));
    EXPECT_THAT(said, HasSubstr("button right"));

    const auto json = nlohmann::json::parse(FormatDeviceCheckJson("reported", *served.servo, r));
    EXPECT_EQ(json["ok"], true);
    EXPECT_EQ(json["buttons"], "clutch, spindle, right, left");
    EXPECT_EQ(json["still"]["samples"], r.still_samples);
    EXPECT_THAT(FormatDeviceCheck("reported", *served.servo, r), HasSubstr("smallest step 0.0400 mm"));
  });
}

TEST(DeviceCheck, EndsAtOnceWithoutForce) {
  // The force rises within a second, so a late check would find the full force.
  RetryIfStalled(std::chrono::milliseconds(200), [](LongestGap& own) {
    Served served(PatientOptions(), [](ReportedDevice::State& state) { state.on_force = MoveOnSpring; });
    DeviceCheckOptions options = ShortOptions();
    options.circle_s = 60;
    options.goes_on = [&] {
      own.Look();
      return served.device->Look().largest_N < 0.5;
    };
    const DeviceCheckResult r = CheckDevice(*served.servo, options);
    EXPECT_TRUE(r.stopped);
    EXPECT_THAT(r.faults, IsEmpty());
    EXPECT_EQ(r.buttons, 0U);
    EXPECT_LT(r.largest_requested_N, 0.2 * FalconPeakForce());
    EXPECT_TRUE(test::WaitFor([&] { return served.device->Look().reported.f_D_N == Vec3(0); }, 10));
    EXPECT_EQ(nlohmann::json::parse(FormatDeviceCheckJson("reported", *served.servo, r))["ok"], false);
  });
}

TEST(DeviceCheck, MakesNoForceWithADeviceThatHasNone) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    state.traits.makes_force = false;
    state.traits.motion = DriverMotion::kDeflection;
    state.traits.buttons.clear();
  });
  const DeviceCheckResult r = CheckDevice(*served.servo, ShortOptions());
  EXPECT_THAT(r.faults, IsEmpty());
  EXPECT_FALSE(r.made_force);
  EXPECT_EQ(served.device->Look().largest_N, 0);
  EXPECT_THAT(FormatDeviceCheck("reported", *served.servo, r), HasSubstr("the device outputs none"));
}

TEST(DeviceCheck, ReportsEachFault) {
  {
    Served served(PatientOptions(), [](ReportedDevice::State& state) { state.sample.homed = false; });
    DeviceCheckOptions options = ShortOptions();
    options.homing_s = 0.1;
    const DeviceCheckResult r = CheckDevice(*served.servo, options);
    EXPECT_FALSE(r.homed);
    EXPECT_THAT(r.faults, ElementsAre("the handle was not homed within 0.1 s: pull it out"));
    EXPECT_EQ(served.device->Look().largest_N, 0);
  }
  // Only the last second at rest is evaluated.
  RetryIfStalled(std::chrono::milliseconds(500), [](LongestGap& /*own*/) {
    DeviceCheckOptions options = ShortOptions();
    options.buttons_s = 0;
    options.still_s = 1;  // the check measures up to five times
    // One round in ten has no good answer, and the handle is never at rest, because nothing holds it; so no force is
    // made.
    Served served(PatientOptions(), [](ReportedDevice::State& state) {
      state.on_force = [](ReportedDevice::State& s) {
        s.sample.X_DH.p_AB.x = 5 * std::sin(0.1 * static_cast<double>(s.rounds));
        s.end = s.rounds % 10 == 0 ? RoundEnd::kBadAnswer : RoundEnd::kSample;
      };
    });
    const DeviceCheckResult r = CheckDevice(*served.servo, options);
    EXPECT_THAT(r.faults,
                ElementsAre(HasSubstr("never kept still in the middle"), HasSubstr("rounds had no valid answer"),
                            HasSubstr("the handle was never left alone")));
    EXPECT_FALSE(r.made_force);
    EXPECT_EQ(served.device->Look().largest_N, 0);
  });
}

TEST(DeviceCheck, ReportsWhyLessForceWasSentThanRequested) {
  // A round that is 100 ms late also closes the gate, but for a different reason.
  RetryIfStalled(std::chrono::milliseconds(50), [](LongestGap& own) {
    DeviceServoOptions servo = PatientOptions();
    servo.servo.gate.lost_s = 0.05;
    // The device stops answering while the force is on, and stays engaged for seconds.
    Served served(servo, [](ReportedDevice::State& state) {
      state.on_force = [](ReportedDevice::State& s) {
        MoveOnSpring(s);
        if (s.largest_N > 0.5) s.end = RoundEnd::kNoAnswer;
      };
    });
    DeviceCheckOptions options = ShortOptions();
    options.still_s = 1;
    options.circle_s = 2.2;
    options.buttons_s = 0;
    options.goes_on = [&] {
      own.Look();
      return true;
    };
    const DeviceCheckResult r = CheckDevice(*served.servo, options);
    EXPECT_TRUE(r.made_force);
    EXPECT_EQ(r.closed_by, GateReason::kLostSample);
    EXPECT_THAT(r.faults, testing::Contains(HasSubstr("N was sent (no force: the device does not answer)")));
  });
}

TEST(DeviceCheck, UnpluggingUnderForceEndsItImmediatelyWithAFault) {
  Served served(PatientOptions(), [](ReportedDevice::State& state) {
    state.on_force = [](ReportedDevice::State& s) {
      MoveOnSpring(s);
      if (s.largest_N > 0.5) s.is_there = false;
    };
  });
  DeviceCheckOptions options = ShortOptions();
  options.circle_s = 60;
  const DeviceCheckResult r = CheckDevice(*served.servo, options);
  EXPECT_THAT(r.faults, ElementsAre("the device was disconnected during the test"));
  EXPECT_FALSE(r.stopped);
}

TEST(DeviceCheck, RefusesMoreThanAFifthOfThePeak) {
  Served served;
  for (const double fraction : {0.0, 0.005, 0.21, 1.0, std::nan("")}) {
    DeviceCheckOptions options = ShortOptions();
    options.circle_fraction = fraction;
    EXPECT_THROW(CheckDevice(*served.servo, options), Error) << fraction;
  }
  EXPECT_EQ(served.device->Look().largest_N, 0);
}

/// A simulated Falcon in a simulated hand, which run in real time.
class LiveFalcon {
 public:
  LiveFalcon() : hand_(FindDeviceProfile("falcon"), FindHandModel("H3"), {}), model_(hand_, {}) { bus_.PlugIn(model_); }

  std::unique_ptr<DeviceDriver> Open();
  void Home() {
    const std::lock_guard lock(mutex_);
    hand_.Home();
  }
  bool homed() {
    const std::lock_guard lock(mutex_);
    return model_.homed() && !hand_.homing();
  }
  std::array<int, 3> motors() {
    const std::lock_guard lock(mutex_);
    return model_.last_command().motors;
  }
  int uploads() {
    const std::lock_guard lock(mutex_);
    return model_.uploads();
  }
  void Unplug() {
    const std::lock_guard lock(mutex_);
    UsbFaults faults;
    faults.unplugged = true;
    bus_.SetFaults(faults);
  }
  void PlugInAgain() {
    const std::lock_guard lock(mutex_);
    bus_.PlugInAgain();
  }

 private:
  class Driver;
  std::mutex mutex_;
  ScriptedHand hand_;
  FalconModel model_;
  ModelBus bus_;
};

/// Advances the model by at most 20 ms per round, however late the round is; the hand continues from there.
class LiveFalcon::Driver final : public DeviceDriver {
 public:
  Driver(LiveFalcon& falcon, std::unique_ptr<FalconDriver> driver)
      : falcon_(falcon), driver_(std::move(driver)), last_(std::chrono::steady_clock::now()) {}
  ~Driver() override {
    const std::lock_guard lock(falcon_.mutex_);
    driver_.reset();
  }
  const DeviceProfile& profile() const override { return driver_->profile(); }
  const DriverTraits& traits() const override { return driver_->traits(); }
  void Start(const std::function<bool(const std::string&, double)>& show) override {
    const std::lock_guard lock(falcon_.mutex_);
    driver_->Start(show);
  }
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override {
    const std::lock_guard lock(falcon_.mutex_);
    const auto now = std::chrono::steady_clock::now();
    falcon_.bus_.Advance(std::min(0.02, std::chrono::duration<double>(now - last_).count()));
    last_ = now;
    return driver_->Exchange(command, sample);
  }
  void Stop() noexcept override {
    const std::lock_guard lock(falcon_.mutex_);
    driver_->Stop();
  }

 private:
  LiveFalcon& falcon_;
  std::unique_ptr<FalconDriver> driver_;
  std::chrono::steady_clock::time_point last_;
};

std::unique_ptr<DeviceDriver> LiveFalcon::Open() {
  const std::lock_guard lock(mutex_);
  FalconOptions options;
  options.firmware.assign(2000, 0x5a);
  const std::vector<UsbDeviceInfo> devices = bus_.List();
  if (devices.empty()) throw Error("no Falcon is plugged in");
  return std::make_unique<Driver>(
      *this, std::make_unique<FalconDriver>(bus_.Open(devices.front(), kFalconInterface).transport, options));
}

TEST(DeviceCheck, PassesWithASimulatedFalconThatIsUnpluggedAfterwards) {
  std::unique_ptr<LiveFalcon> falcon;
  std::unique_ptr<DeviceServo> servo;
  RetryIfStalled(std::chrono::milliseconds(1000), [&](LongestGap& own) {
    servo.reset();
    falcon = std::make_unique<LiveFalcon>();
    servo = std::make_unique<DeviceServo>(
        "falcon", [&] { return falcon->Open(); }, PatientOptions(), [](const std::string&, double) { return true; });
    DeviceCheckOptions options = ShortOptions();
    options.buttons_s = 0;
    options.goes_on = [&] {
      own.Look();
      return true;
    };
    options.say = [&](const std::string& text) {
      if (text.find("no force until then") != std::string::npos) falcon->Home();
    };
    const DeviceCheckResult r = CheckDevice(*servo, options);
    EXPECT_THAT(r.faults, IsEmpty());
    EXPECT_TRUE(r.homed);
    EXPECT_NEAR(r.largest_requested_N, 0.2 * FalconPeakForce(), 1e-9);
    EXPECT_GT(r.moved_mm, 0.5);
    EXPECT_GT(r.followed, 0.5);
  });
  ASSERT_TRUE(test::WaitFor([&] { return falcon->motors() == std::array<int, 3>{}; }));

  // The device is unplugged while the force is on.
  const auto push = [&] {
    DriverCommand command;
    command.f_D_N = {0, 1, 0};
    servo->Command(command);
  };
  ASSERT_TRUE(test::WaitFor([&] {
    push();
    return falcon->motors() != std::array<int, 3>{};
  }));
  falcon->Unplug();
  ASSERT_TRUE(test::WaitFor([&] { return servo->state() == ServoState::kClosed; }));
  falcon->PlugInAgain();
  ASSERT_TRUE(test::WaitFor([&] {
    push();
    return servo->state() == ServoState::kHoming;
  }));
  EXPECT_EQ(falcon->uploads(), 2);
  falcon->Home();
  ASSERT_TRUE(test::WaitFor([&] {
    push();
    EXPECT_EQ(falcon->motors(), (std::array<int, 3>{}));
    return servo->state() == ServoState::kWaiting;
  }));
  servo->Agree();
  EXPECT_TRUE(test::WaitFor([&] {
    push();
    return falcon->motors() != std::array<int, 3>{};
  }));
}

TEST(WatchDevice, ShowsThePositionOnlyWhileTheDeviceAnswers) {
  DeviceServoOptions options = PatientOptions();
  options.servo.silent_s = options.servo.agree_s = 0.3;
  Served served(options, [](ReportedDevice::State& state) {
    state.sample.X_DH.p_AB = {1.25, -2.5, 30};
    state.sample.buttons = 0b0100;
  });
  const char* const reported = "right    +1.25  up    -2.50  towards you   +30.00 mm; buttons right";
  // Each text that must be shown next, with the change to the device that follows it.
  const std::vector<std::pair<std::string, std::function<void(ReportedDevice::State&)>>> steps = {
      {reported, [](ReportedDevice::State& state) { state.end = RoundEnd::kNoAnswer; }},
      {"; no answer", [](ReportedDevice::State& state) { state.end = RoundEnd::kSample; }},
      {reported, [](ReportedDevice::State& state) { state.is_there = false; }},
      {"not connected", [](ReportedDevice::State& state) { state.is_there = true; }},
      {reported, [](ReportedDevice::State& /*state*/) {}}};
  std::size_t next = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(test::kLongWait_s);
  WatchDevice(
      *served.servo, [&] { return next < steps.size() && std::chrono::steady_clock::now() < end; },
      [&](const std::string& line, bool passing) {
        if (!passing || next == steps.size()) return;
        EXPECT_EQ(line.ends_with(reported), line.find(" mm") != std::string::npos) << line;
        if (!line.ends_with(steps[next].first)) return;
        served.device->With(steps[next].second);
        ++next;
      });
  EXPECT_EQ(next, steps.size()) << "never shown: " << steps[std::min(next, steps.size() - 1)].first;
}

}  // namespace
}  // namespace kerf
