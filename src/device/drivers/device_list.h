// All devices that kerf can speak to, and which of them are there.
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

/// What each kind of device may be told.
struct DriverOptions {
  FalconOptions falcon;
  WoodenParams wooden;
  SpaceMouseOptions spacemouse;
  BridgeOptions bridge;
  HaplyOptions haply;
  int ask_for_ms = 300;  // at most, to see whether a device on the network is there (FindFarDevices)
};

struct UsbNumbers {
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
};

/// A kind of device.
struct KnownDevice {
  std::string name;  // for --device
  std::string what;  // "Novint Falcon"
  std::string link;  // how it is reached: "USB", "USB HID", "UDP", "WebSocket"
  bool makes_force = true;
  std::vector<UsbNumbers> numbers;  // none: not on USB
};
const std::vector<KnownDevice>& KnownDevices();

enum class DeviceState : std::uint8_t {
  kReady,
  kNoPermission,
  kBusy,
  kNoFirmware,
  kOtherGadget,  // has the numbers of one that kerf knows, and is none
  kFailed,       // opened, but it does not work
};
const char* ToString(DeviceState state);  // "ready", "no_permission", ...

/// One that is there.
struct FoundDevice {
  const KnownDevice* kind = nullptr;
  std::string model;   // where one kind has several: "SpaceNavigator"; else as `what`
  UsbDeviceInfo usb;   // vendor 0: not on USB
  std::string where;   // "1-2 (0403:cb48)": the socket and the numbers; "127.0.0.1:47810"
  std::string choice;  // for --device: the kind's name, or with "@" and the socket where there are several of it
  DeviceState state = DeviceState::kReady;
  std::string problem;  // a phrase; "" where it is ready
  std::string mend;     // what the user does about it, a sentence with the command
};

/// Opens and starts each, which moves nothing, and lets go of it. Takes a second or two for each device, a minute for
/// a Falcon whose boot loader does not answer, where there is firmware for it. Throws Error when USB can't be asked.
std::vector<FoundDevice> FindDevices(UsbBus& bus, const DriverOptions& options = {});
/// Those on USB, and those that answer on the network, where the options say that they are; waits for each step of
/// theirs for DriverOptions::ask_for_ms at most.
std::vector<FoundDevice> FindUsbDevices(UsbBus& bus, const DriverOptions& options = {});
std::vector<FoundDevice> FindFarDevices(const DriverOptions& options = {});

/// `choice` is a kind's name, or that with "@" and the socket: "falcon@1-2". Opened but not started. Throws Error: not
/// there, or there and why it can't be opened and what the user can do.
std::unique_ptr<DeviceDriver> OpenDriver(UsbBus& bus, const std::string& choice, const DriverOptions& options);

/// The kind that a choice names. Throws Error with the nearest when there is none.
const KnownDevice& FindKnownDevice(const std::string& choice);

/// The file for udev that lets users at all of them, with how to install it as a comment.
std::string MakeUdevRules();

}  // namespace kerf
