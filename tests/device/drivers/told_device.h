// A device that does what a test says, for the servo that serves it and what is built on that.
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

/// A machine may be as busy as it likes: what is waited for comes in the end, or never.
constexpr double kLongWait_s = 30;

inline bool WaitFor(const std::function<bool()>& condition, double limit_s = kLongWait_s) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(limit_s);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// What the device is, whoever drives it. All under one lock.
class ToldDevice {
 public:
  struct State {
    DeviceProfile profile = FindDeviceProfile("falcon");
    DriverTraits traits;
    DriverSample sample;
    RoundEnd end = RoundEnd::kSample;
    bool is_there = true;
    std::string fails_to_open;     // an Error, where it is not empty
    std::string fails_to_start;    // likewise
    bool fails_otherwise = false;  // opening throws what is no Error
    // what it was told
    DriverCommand told;
    std::uint64_t rounds = 0;
    double largest_N = 0;  // since somebody made it 0
    int asked = 0;         // to be opened
    int opened = 0;
    int stopped = 0;
    /// Moves the handle by the force, once a round.
    std::function<void(State&)> feels;
  };

  ToldDevice() {
    state_.traits.buttons = {"clutch", "spindle", "right", "left"};
    state_.traits.homes = true;
    state_.traits.homing = "pull it out";
  }

  /// With the device held still.
  template <typename Function>
  auto With(Function function) {
    const std::lock_guard lock(mutex_);
    return function(state_);
  }
  State Look() {
    return With([](const State& state) { return state; });
  }
  /// Until whatever was changed before has been told to the loop: a whole round and the beginning of the next.
  bool PassRounds(std::uint64_t rounds = 2) {
    const std::uint64_t now = Look().rounds;
    return WaitFor([&] { return Look().rounds >= now + rounds; });
  }

 private:
  std::mutex mutex_;
  State state_;
};

class ToldDeviceDriver final : public DeviceDriver {
 public:
  explicit ToldDeviceDriver(std::shared_ptr<ToldDevice> device) : device_(std::move(device)) {
    device_->With([this](ToldDevice::State& state) {
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
    return device_->With([&](ToldDevice::State& state) {
      ++state.rounds;
      if (!state.is_there) return RoundEnd::kGone;
      state.told = command;
      state.largest_N = std::max(state.largest_N, glm::length(command.f_D_N));
      if (state.feels) state.feels(state);
      if (state.end == RoundEnd::kSample) sample = state.sample;
      return state.end;
    });
  }
  void Stop() noexcept override {
    device_->With([](ToldDevice::State& state) { ++state.stopped; });
  }

 private:
  std::shared_ptr<ToldDevice> device_;
  DeviceProfile profile_;
  DriverTraits traits_;
};

inline DeviceServo::Open OpenTold(const std::shared_ptr<ToldDevice>& device) {
  return [device]() -> std::unique_ptr<DeviceDriver> {
    const ToldDevice::State state = device->With([](ToldDevice::State& s) {
      ++s.asked;
      return s;
    });
    if (state.fails_otherwise) throw std::runtime_error("no memory, perhaps");
    if (!state.fails_to_open.empty()) throw Error(state.fails_to_open);
    if (!state.is_there) throw DeviceNotThere("it is not there");
    return std::make_unique<ToldDeviceDriver>(device);
  };
}

/// Of a machine that may stand still for seconds, but where the test is about just that.
inline DeviceServoOptions PatientOptions() {
  DeviceServoOptions options;
  options.priority = 0;
  options.reopen_s = 0.01;
  options.old_s = 20;
  options.given_up_s = 60;
  options.servo.silent_s = 10;
  options.servo.agree_s = 20;
  options.servo.gate.stale_s = 20;
  options.servo.gate.lost_s = 20;
  options.servo.leap_mm_per_s = 1e9;   // it is put from one place to another
  options.servo.leap_rad_per_s = 1e9;  // and turned
  return options;
}

/// A device and what serves it.
class Served {
 public:
  explicit Served(const DeviceServoOptions& options = PatientOptions(),
                  const std::function<void(ToldDevice::State&)>& prepare = {}) {
    if (prepare) device->With(prepare);
    servo = std::make_unique<DeviceServo>("told", OpenTold(device), options,
                                          [](const std::string&, double) { return true; });
  }

  bool Await(ServoState state) const {
    return WaitFor([&] { return servo->state() == state; });
  }
  void Engage(const Pose& X_WT, const ServedTool& tool = {}) {
    servo->SetTool(X_WT, tool);
    ASSERT_TRUE(Await(ServoState::kWaiting));
    servo->Agree();
    ASSERT_TRUE(Await(ServoState::kEngaged));
    ASSERT_TRUE(device->PassRounds());
  }
  /// A tick of the loop, within which no memory is asked for.
  bool Tick(const Vec3& f_W_N = Vec3{0}, const Vec3& tau_W_Nmm = Vec3{0}) {
    const HeapGuard guard;
    servo->Elapse(0.001);
    const bool read = servo->Read(sample);
    servo->Write(f_W_N, tau_W_Nmm);
    return read;
  }
  /// As the loop goes on asking for a force.
  bool TickUntil(const Vec3& f_W_N, const std::function<bool()>& condition) {
    return WaitFor([&] {
      Tick(f_W_N);
      return condition();
    });
  }
  /// The force that goes out is, and stays, this.
  bool AwaitForce(const Vec3& f_W_N, const Vec3& f_D_N, double tolerance_N = 1e-9) {
    return TickUntil(f_W_N, [&] { return glm::length(device->Look().told.f_D_N - f_D_N) <= tolerance_N; });
  }
  void MoveHandle(const Vec3& p_D_mm) {
    device->With([&](ToldDevice::State& state) { state.sample.X_DH.p_AB = p_D_mm; });
    ASSERT_TRUE(device->PassRounds());
  }
  void Press(std::uint32_t buttons) {
    device->With([&](ToldDevice::State& state) { state.sample.buttons = buttons; });
    ASSERT_TRUE(device->PassRounds());
  }
  /// All that was said since the last call, in one text.
  std::string Messages() const {
    std::string text;
    for (const std::string& message : servo->TakeMessages()) text += message + "\n";
    return text;
  }
  /// Said since the last call, or soon; what was said with it is not told again.
  bool AwaitMessage(const std::string& part) const {
    std::string text;
    return WaitFor([&] {
      text += Messages();
      return text.find(part) != std::string::npos;
    });
  }

  std::shared_ptr<ToldDevice> device = std::make_shared<ToldDevice>();
  std::unique_ptr<DeviceServo> servo;
  DeviceSample sample;
};

}  // namespace kerf::test
