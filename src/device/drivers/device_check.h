// Test of a connected device: the position of its handle, its force, rate and resolution.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "device/drivers/device_servo.h"

namespace kerf {

struct DeviceCheckOptions {
  double homing_s = 60;
  double still_s = 2;   // duration of the measurement with the handle at rest
  double circle_s = 8;  // two turns
  bool up = false;      // true: the force points up instead of rotating, for lifting weights
  double circle_fraction = 0.2;
  double buttons_s = 5;  // until all have been pressed
  /// Called repeatedly; if it returns false, the test ends immediately and the force is zero. Optional.
  std::function<bool()> goes_on;
  /// Receives progress reports and instructions to the user. Optional.
  std::function<void(const std::string&)> say;
};

template <typename V>
void Describe(DeviceCheckOptions& p, V&& visit) {
  visit("circle_fraction", p.circle_fraction, Range{0.01, 0.2},
        "force of the circle, as a fraction of the device's peak");
  visit("circle_s", p.circle_s, Range{2, 60}, "duration of the circle");
  visit("buttons_s", p.buttons_s, Range{0, 60}, "time to wait for the buttons");
  visit("homing_s", p.homing_s, Range{0, 600}, "time to wait for homing");
}

struct DeviceCheckResult {
  bool stopped = false;  // stopped by the user: the values below are incomplete
  bool homed = false;
  // The handle at rest, frame D.
  std::uint64_t still_samples = 0;
  double rate_hz = 0;        // rate of samples
  Vec3 noise_mm{0};          // standard deviation
  Vec3 span_mm{0};           // maximum minus minimum
  double least_step_mm = 0;  // smallest nonzero difference between consecutive samples along an axis; 0: none
  // The rotating force.
  bool made_force = false;  // the device can output force, and it was tested
  double largest_requested_N = 0;
  double largest_sent_N = 0;  // largest force that the safety gate passed
  double moved_mm = 0;        // maximum distance of the handle from its start
  double followed = 0;        // fraction of that motion along the force: 1: all, 0: none, negative: against the force
  std::uint32_t buttons = 0;  // bits of the buttons that were pressed
  Percentiles round;          // duration of a round, sending and receiving
  ServoCounts rounds;
  GateReason closed_by = GateReason::kNone;  // SafetyGate::closed_by()
  std::vector<std::string> faults;           // one sentence each; empty: the device passed
};

/// Runs the test and returns when it has ended; no other thread may use the servo. The force stays below
/// circle_fraction of the peak force. Throws kerf::Error if an option is out of range.
DeviceCheckResult CheckDevice(DeviceServo& servo, const DeviceCheckOptions& options);

/// Shows the position and the buttons ten times a second through `show`, without force, until `goes_on` returns false.
/// `transient` marks a line that the next one may replace.
void WatchDevice(DeviceServo& servo, const std::function<bool()>& goes_on,
                 const std::function<void(const std::string& line, bool transient)>& show);

/// Returns a description such as "falcon (falcon, up to 8 N)".
std::string DescribeOpenDevice(const std::string& name, const DeviceServo& servo);
/// Returns JSON with stable keys that include units.
std::string FormatDeviceCheckJson(const std::string& name, const DeviceServo& servo, const DeviceCheckResult& result);
/// Returns the result as text for the user.
std::string FormatDeviceCheck(const std::string& name, const DeviceServo& servo, const DeviceCheckResult& result);

}  // namespace kerf
