// A look at a device that is there: does its handle tell where it is, does its force come, how fast and how finely.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "device/drivers/device_servo.h"

namespace kerf {

struct DeviceCheckOptions {
  double homing_s = 60;       // to wait for the handle to be moved
  double still_s = 2;         // of a handle that nobody moves
  double circle_s = 8;        // of a force that goes round, twice
  bool up = false;            // it points up all the time instead, for weights to be lifted
  double circle_share = 0.2;  // of the device's peak, 0.01 to 0.2
  double buttons_s = 5;       // to press each button
  /// False ends it at once, without force. May be empty.
  std::function<bool()> goes_on;
  /// What the user is to do, and what happens. May be empty.
  std::function<void(const std::string&)> say;
};

struct DeviceCheckTimes {
  double p50_us = 0;
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};

struct DeviceCheckResult {
  bool stopped = false;  // by the user: what follows is not there
  bool homed = false;
  // a handle at rest, frame D
  std::uint64_t still_samples = 0;
  double rate_hz = 0;        // of samples
  Vec3 noise_mm{0};          // standard deviation
  Vec3 span_mm{0};           // from the least to the most
  double least_step_mm = 0;  // the least difference of two samples in a row along an axis; 0: there was none
  // the force's circle
  bool made_force = false;  // the device can, and it was tried
  double largest_asked_N = 0;
  double largest_sent_N = 0;  // by the safety gate
  double moved_mm = 0;        // the handle's farthest place from where it was
  double followed = 0;        // of that motion, how much goes with the force: 1 all of it, 0 none, below 0 against it
  std::uint32_t buttons = 0;  // that were pressed
  DeviceCheckTimes round;     // there and back
  ServoCounts rounds;
  GateReason closed_by = GateReason::kNone;  // SafetyGate::closed_by()
  std::vector<std::string> faults;           // a sentence each; none: all is well
};

/// Waits, with nobody else at the servo. Stays below circle_share of the peak. Throws Error for an option out of range.
DeviceCheckResult CheckDevice(DeviceServo& servo, const DeviceCheckOptions& options);

/// Shows place and buttons ten times a second by `show`, without force, until `goes_on` is false. `passing`: a line
/// that the next may take the place of.
void WatchDevice(DeviceServo& servo, const std::function<bool()>& goes_on,
                 const std::function<void(const std::string& line, bool passing)>& show);

/// "falcon (falcon, up to 8 N)".
std::string DescribeServedDevice(const std::string& name, const DeviceServo& servo);
/// Stable keys with units.
std::string FormatDeviceCheckJson(const std::string& name, const DeviceServo& servo, const DeviceCheckResult& result);
/// For people.
std::string FormatDeviceCheck(const std::string& name, const DeviceServo& servo, const DeviceCheckResult& result);

}  // namespace kerf
