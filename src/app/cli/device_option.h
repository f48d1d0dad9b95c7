// Options for the device that a command uses.
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
#include "session/link/tracked_tool.h"
#include "session/scene/scene.h"

namespace kerf::cli {

inline constexpr char kDeviceOption[] = "--device";

struct DeviceOption {
  std::string called = kDeviceOption;  // name on the command line
  std::string device;                  // empty: simulated
  std::string falcon_firmware;         // file
  std::string wooden;                  // file
  std::string bridge;                  // ADDRESS:PORT
  bool bridge_elsewhere = false;
  std::optional<double> motion_scale;
  bool left_handed = false;
  std::string profile;
  std::shared_ptr<TrackedTool> tracked_tool;  // of the link, for the device "igtl"; null: there is no link
};

template <typename V>
void Describe(DeviceOption& p, V&& visit) {
  DescribeMotion(p, visit);
}

/// Adds --device and the options that belong to it. `played`: also accepts "none", "script:FILE" and "recording:FILE".
CLI::Option* AddDeviceOption(CLI::App& command, DeviceOption& option, bool played);
/// Adds only the options of drivers: --falcon-firmware, --wooden, --bridge and --bridge-elsewhere.
void AddDriverOptions(CLI::App& command, DeviceOption& option);

/// Reads the files that the options name. Throws Error.
DriverOptions MakeDriverOptions(const DeviceOption& option);

/// Throws CLI::ValidationError if the device does not exist (the message names the nearest one), or if an option
/// belongs to another device or needs a real device.
void CheckDeviceOption(const DeviceOption& option);

/// Opens a real device, loading its firmware if needed, and sets the scene's [device] from it. Progress is printed on
/// stderr. Returns null if the device is simulated or played. Throws Error.
std::shared_ptr<DeviceServo> OpenServo(const DeviceOption& option, Scene& scene, const std::atomic<bool>* stop);
/// Does the same without a scene.
std::shared_ptr<DeviceServo> OpenServo(const DeviceOption& option, const DeviceServoOptions& servo,
                                       const std::atomic<bool>* stop);

/// Returns a device that plays back poses; empty if the option names another kind of device.
LoopDevice MakePlayedDevice(const DeviceOption& option);

/// Prints the servo's messages on stderr. On a terminal, Enter confirms that force may be enabled again. `waited`:
/// state kept between calls; initially false.
void FollowServo(DeviceServo& servo, bool& waited);

}  // namespace kerf::cli
