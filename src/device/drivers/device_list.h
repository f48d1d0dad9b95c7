// All devices that kerf supports, and which of them are connected.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "device/devices/driver.h"
#include "device/devices/falcon/falcon_driver.h"
#include "device/devices/hid/spacemouse_driver.h"
#include "device/devices/hid/wooden_params.h"
#include "device/devices/usb.h"
#include "device/drivers/bridge_driver.h"
#include "device/drivers/haply_driver.h"

namespace kerf {

/// Options for each kind of device.
struct DriverOptions {
  FalconOptions falcon;
  WoodenParams wooden;
  SpaceMouseOptions spacemouse;
  BridgeOptions bridge;
  HaplyOptions haply;
  int ask_for_ms = 300;  // maximum time to find out whether a network device is present (FindFarDevices)
};

struct UsbNumbers {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
};

/// Kind of device.
struct KnownDevice {
  std::string name;  // for --device
  std::string what;  // "Novint Falcon"
  std::string link;  // connection: "USB", "USB HID", "UDP", "WebSocket"
  bool makes_force = true;
  std::vector<UsbNumbers> numbers;  // empty: not on USB
};
const std::vector<KnownDevice>& KnownDevices();

enum class DeviceState : std::uint8_t {
  kReady,
  kNoPermission,
  kBusy,
  kNoFirmware,
  kOtherGadget,  // has the USB ID of a known device but is a different one
  kFailed,       // was opened, but does not work
};
const char* ToString(DeviceState state);  // "ready", "no_permission", ...

/// Device that is connected.
struct FoundDevice {
  const KnownDevice* kind = nullptr;
  std::string model;   // if a kind has several models: "SpaceNavigator"; otherwise the same as `what`
  UsbDeviceInfo usb;   // vendor 0: not on USB
  std::string where;   // "1-2 (0403:cb48)": port and USB ID; "127.0.0.1:47810"
  std::string choice;  // for --device: the kind's name, with "@" and the port if there are several of that kind
  DeviceState state = DeviceState::kReady;
  std::string problem;  // phrase; "" if ready
  std::string remedy;   // remedy for the user: a sentence with the command
};

/// Opens, starts and closes each device without moving it. Takes a second or two per device, and a minute for a Falcon
/// whose boot loader does not answer, if firmware is supplied. Throws kerf::Error if USB cannot be queried.
std::vector<FoundDevice> FindDevices(UsbBus& bus, const DriverOptions& options = {});
/// Devices on USB, and devices that answer on the network at the addresses in the options; each step waits at most
/// DriverOptions::ask_for_ms.
std::vector<FoundDevice> FindUsbDevices(UsbBus& bus, const DriverOptions& options = {});
std::vector<FoundDevice> FindFarDevices(const DriverOptions& options = {});

/// Opens a device without starting it. `choice` is a kind's name, optionally with "@" and the port: "falcon@1-2".
/// Throws kerf::Error with the reason and the remedy if it is not present or cannot be opened.
std::unique_ptr<DeviceDriver> OpenDriver(UsbBus& bus, const std::string& choice, const DriverOptions& options);

/// Returns the kind that a choice names. Throws a kerf::Error that names the nearest kind if there is none.
const KnownDevice& FindKnownDevice(const std::string& choice);

/// Returns a udev rules file that lets users access all devices, with installation instructions in a comment.
std::string MakeUdevRules();

}  // namespace kerf
