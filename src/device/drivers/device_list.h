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
  int probe_timeout_ms = 300;  // maximum time to find out whether a network device is present (FindNetworkDevices)
};

struct UsbNumbers {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
};

/// A kind of device.
struct KnownDevice {
  std::string name;  // for --device
  std::string what;  // description, such as "Novint Falcon"
  std::string link;  // connection: "USB", "USB HID", "UDP" or "WebSocket"
  bool makes_force = true;
  std::vector<UsbNumbers> numbers;  // USB IDs; empty: not a USB device
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

/// A device that is connected.
struct FoundDevice {
  const KnownDevice* kind = nullptr;
  std::string model;   // model, such as "SpaceNavigator", if a kind has several; otherwise the same as `what`
  UsbDeviceInfo usb;   // vendor 0: not on USB
  std::string where;   // port and USB ID, or address: "1-2 (0403:cb48)", "127.0.0.1:47810"
  std::string choice;  // for --device: the kind's name, with "@" and the port if there are several of that kind
  DeviceState state = DeviceState::kReady;
  std::string problem;  // a phrase; "" if ready
  std::string remedy;   // what the user can do: a sentence with the command
};

/// Lists the connected devices. Opens, starts and closes each one without moving it. This takes a second or two per
/// device; if firmware is supplied, it takes a minute for a Falcon whose boot loader does not answer. Throws
/// kerf::Error if USB cannot be queried.
std::vector<FoundDevice> FindDevices(UsbBus& bus, const DriverOptions& options = {});
/// The first of these functions lists only the devices on USB; the second lists only those that answer on the network
/// at the addresses in the options, and waits at most DriverOptions::probe_timeout_ms in each step.
std::vector<FoundDevice> FindUsbDevices(UsbBus& bus, const DriverOptions& options = {});
std::vector<FoundDevice> FindNetworkDevices(const DriverOptions& options = {});

/// Opens a device without starting it. `choice` is a kind's name, optionally with "@" and the port: "falcon@1-2".
/// Throws kerf::Error with the reason and the remedy if the device is not present or cannot be opened.
std::unique_ptr<DeviceDriver> OpenDriver(UsbBus& bus, const std::string& choice, const DriverOptions& options);

/// Returns the kind that a choice names. If there is none, throws a kerf::Error that suggests the most similar name.
const KnownDevice& FindKnownDevice(const std::string& choice);

/// Returns a udev rules file that lets users access all devices, with installation instructions in a comment.
std::string MakeUdevRules();

}  // namespace kerf
