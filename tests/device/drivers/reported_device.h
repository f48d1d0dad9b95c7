// A device whose behaviour a test defines, for tests of the device servo and of code that uses the servo.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "base/core/heap_guard.h"
#include "device/devices/profiles.h"
#include "device/drivers/device_servo.h"
#include "kerf/error.h"

namespace kerf::test {

/// Upper limit for waits; the machine may be very busy.
constexpr double kLongWait_s = 30;

inline bool WaitFor(const std::function<bool()>& condition, double limit_s = kLongWait_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// State of the device, shared by all its drivers and protected by one lock.
class ReportedDevice {
 public:
  struct State {
    DeviceProfile profile = FindDeviceProfile("falcon");
    DriverTraits traits;
    DriverSample sample;
    RoundEnd end = RoundEnd::kSample;
    bool is_there = true;
    std::string fails_to_open;     // opening throws Error with this text; if empty, opening succeeds
    std::string fails_to_start;    // the same for starting
    bool fails_otherwise = false;  // opening throws an exception other than Error
    // values received and counts
    DriverCommand reported;
    std::uint64_t rounds = 0;
    double largest_N = 0;  // since it was last set to 0
    int asked = 0;         // number of attempts to open it
    int opened = 0;
    int stopped = 0;
    /// Moves the handle according to the force, once per round.
    std::function<void(State&)> on_force;
  };

  ReportedDevice() {
    state_.traits.buttons = {"clutch", "spindle", "right", "left"};
    state_.traits.homes = true;
    state_.traits.homing = "pull it out";
  }

  /// Calls `function` with the state locked.
  template <typename Function>
  auto With(Function function) {
    const std::lock_guard lock(mutex_);
    return function(state_);
  }
  State Look() {
    return With([](const State& state) { return state; });
  }
  /// Waits until the servo has seen all earlier changes: for one full round and the start of the next.
  bool PassRounds(std::uint64_t rounds = 2) {
    const std::uint64_t now = Look().rounds;
    return WaitFor([&] { return Look().rounds >= now + rounds; });
  }

 private:
  std::mutex mutex_;
  State state_;
};

class ReportedDeviceDriver final : public DeviceDriver {
 public:
  explicit ReportedDeviceDriver(std::shared_ptr<ReportedDevice> device) : device_(std::move(device)) {
    device_->With([this](ReportedDevice::State& state) {
      profile_ = state.profile;
      traits_ = state.traits;
      ++state.opened;
    });
  }
  const DeviceProfile& profile() const override { return profile_; }
  const DriverTraits& traits() const override { return traits_; }
  void Start(const std::function<bool(const std::string&, double)>& /*show*/) override {
    const std::string failure = device_->Look().fails_to_start;
    if (!failure.empty()) throw Error(failure);
  }
  RoundEnd Exchange(const DriverCommand& command, DriverSample& sample) noexcept override {
    return device_->With([&](ReportedDevice::State& state) {
      ++state.rounds;
      if (!state.is_there) return RoundEnd::kGone;
      state.reported = command;
      state.largest_N = std::max(state.largest_N, glm::length(command.f_D_N));
      if (state.on_force) state.on_force(state);
      if (state.end == RoundEnd::kSample) sample = state.sample;
      return state.end;
    });
  }
  void Stop() noexcept override {
    device_->With([](ReportedDevice::State& state) { ++state.stopped; });
  }

 private:
  std::shared_ptr<ReportedDevice> device_;
  DeviceProfile profile_;
  DriverTraits traits_;
};

inline DeviceServo::Open OpenReported(const std::shared_ptr<ReportedDevice>& device) {
  return [device]() -> std::unique_ptr<DeviceDriver> {
    const ReportedDevice::State state = device->With([](ReportedDevice::State& s) {
      ++s.asked;
      return s;
    });
    if (state.fails_otherwise) throw std::runtime_error("no memory, perhaps");
    if (!state.fails_to_open.empty()) throw Error(state.fails_to_open);
    if (!state.is_there) throw DeviceNotThere("it is not there");
    return std::make_unique<ReportedDeviceDriver>(device);
  };
}

/// Options for a machine that may stall for seconds, except where a test is about such delays.
inline DeviceServoOptions PatientOptions() {
  DeviceServoOptions options;
  options.priority = 0;
  options.reopen_s = 0.01;
  options.max_sample_age_s = 20;
  options.restart_after_s = 60;
  options.servo.silent_s = 10;
  options.servo.agree_s = 20;
  options.servo.gate.stale_s = 20;
  options.servo.gate.lost_s = 20;
  options.servo.max_speed_mm_per_s = 1e9;   // tests move the handle in jumps
  options.servo.max_speed_rad_per_s = 1e9;  // and rotate it in jumps
  return options;
}

/// A device and its servo.
class Served {
 public:
  explicit Served(const DeviceServoOptions& options = PatientOptions(),
                  const std::function<void(ReportedDevice::State&)>& prepare = {}) {
    if (prepare) device->With(prepare);
    servo = std::make_unique<DeviceServo>("reported", OpenReported(device), options,
                                          [](const std::string&, double) { return true; });
  }

  bool Await(ServoState state) const {
    return WaitFor([&] { return servo->state() == state; });
  }
  void Engage(const Pose& X_WT, const ToolCoupling& tool = {}) {
    servo->SetTool(X_WT, tool);
    ASSERT_TRUE(Await(ServoState::kWaiting));
    servo->Agree();
    ASSERT_TRUE(Await(ServoState::kEngaged));
    ASSERT_TRUE(device->PassRounds());
  }
  /// Runs one tick of the loop, during which no memory may be allocated.
  bool Tick(const Vec3& f_W_N = Vec3{0}, const Vec3& tau_W_Nmm = Vec3{0}) {
    const HeapGuard guard;
    servo->Elapse(0.001);
    const bool read = servo->Read(sample);
    servo->Write(f_W_N, tau_W_Nmm);
    return read;
  }
  /// Runs ticks with a constant requested force until the condition is true.
  bool TickUntil(const Vec3& f_W_N, const std::function<bool()>& condition) {
    return WaitFor([&] {
      Tick(f_W_N);
      return condition();
    });
  }
  /// Runs ticks until the force that is sent is `f_D_N`.
  bool AwaitForce(const Vec3& f_W_N, const Vec3& f_D_N, double tolerance_N = 1e-9) {
    return TickUntil(f_W_N, [&] { return glm::length(device->Look().reported.f_D_N - f_D_N) <= tolerance_N; });
  }
  void MoveHandle(const Vec3& p_D_mm) {
    device->With([&](ReportedDevice::State& state) { state.sample.X_DH.p_AB = p_D_mm; });
    ASSERT_TRUE(device->PassRounds());
  }
  void Press(std::uint32_t buttons) {
    device->With([&](ReportedDevice::State& state) { state.sample.buttons = buttons; });
    ASSERT_TRUE(device->PassRounds());
  }
  /// Returns all messages since the last call as one text.
  std::string Messages() const {
    std::string text;
    for (const std::string& message : servo->TakeMessages()) text += message + "\n";
    return text;
  }
  /// Waits for a message that contains `part`, starting with those since the last call; other messages are discarded.
  bool AwaitMessage(const std::string& part) const {
    std::string text;
    return WaitFor([&] {
      text += Messages();
      return text.find(part) != std::string::npos;
    });
  }

  std::shared_ptr<ReportedDevice> device = std::make_shared<ReportedDevice>();
  std::unique_ptr<DeviceServo> servo;
  DeviceSample sample;
};

}  // namespace kerf::test
