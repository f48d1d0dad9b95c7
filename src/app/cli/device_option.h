// The device that a command is to use, and what it needs.
#pragma once

#include <CLI/CLI.hpp>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "device/drivers/device_list.h"
#include "device/drivers/device_servo.h"
#include "loop/haptics/loop_device.h"
#include "session/held_device/hold_tool.h"
#include "session/scene/scene.h"

namespace kerf::cli {

inline constexpr char kDeviceOption[] = "--device";

struct DeviceOption {
  std::string called = kDeviceOption;  // on the command line
  std::string device;                  // empty: simulated
  std::string falcon_firmware;         // file
  std::string wooden;                  // file
  std::string bridge;                  // ADDRESS:PORT
  bool bridge_elsewhere = false;
  std::optional<double> motion_scale;
  bool left_handed = false;
  std::string profile;
};

/// --device and what goes with it. `played`: also "none", "script:FILE" and "recording:FILE".
CLI::Option* AddDeviceOption(CLI::App& command, DeviceOption& option, bool played);
/// What a device needs, alone: --falcon-firmware, --wooden.
void AddDriverOptions(CLI::App& command, DeviceOption& option);

/// Reads the files. Throws Error.
DriverOptions MakeDriverOptions(const DeviceOption& option);

/// Throws the command line's error: nothing is called so (it names the nearest device), or an option is another
/// device's, or one's when there is none.
void CheckDeviceOption(const DeviceOption& option);

/// Opens a device that is really there, firmware and all, and puts it into the scene's [device]; what is being done
/// goes to stderr. Null when it is simulated or played. Throws Error.
std::shared_ptr<DeviceServo> OpenServo(const DeviceOption& option, Scene& scene, const std::atomic<bool>* stop);
/// The same without a scene.
std::shared_ptr<DeviceServo> OpenServo(const DeviceOption& option, const DeviceServoOptions& servo,
                                       const std::atomic<bool>* stop);

/// Of a device that is played; empty when it is another.
LoopDevice MakePlayedDevice(const DeviceOption& option);

/// What it says goes to stderr; on a terminal, Enter agrees to have force again.
/// `waited`: between calls; false at first.
void FollowServo(DeviceServo& servo, bool& waited);

}  // namespace kerf::cli
