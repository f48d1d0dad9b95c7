#include "device/drivers/device_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "base/core/nearest_name.h"
#include "device/devices/falcon/falcon_usb.h"
#include "device/devices/hid/wooden_driver.h"
#include "device/drivers/device_servo.h"
#include "device/drivers/far_drivers.h"
#include "device/drivers/libusb_bus.h"
#include "kerf/error.h"

namespace kerf {
namespace {

constexpr const char* kInstallRules =
    "kerf devices --udev-rules | sudo tee /etc/udev/rules.d/70-kerf.rules && sudo udevadm control --reload && sudo "
    "udevadm trigger";

/// Properties of a USB kind in addition to those in KnownDevice.
struct UsbKind {
  const char* name;
  int interface_number;
  bool is_hid;
  std::unique_ptr<DeviceDriver> (*make)(std::unique_ptr<UsbTransport> transport, const UsbDeviceInfo& info,
                                        const DriverOptions& options);
};

constexpr UsbKind kUsbKinds[] = {
    {"falcon", kFalconInterface, false,
     [](std::unique_ptr<UsbTransport> transport, const UsbDeviceInfo&,
        const DriverOptions& options) -> std::unique_ptr<DeviceDriver> {
       return std::make_unique<FalconDriver>(std::move(transport), options.falcon);
     }},
    {"wooden", 0, true,
     [](std::unique_ptr<UsbTransport> transport, const UsbDeviceInfo&,
        const DriverOptions& options) -> std::unique_ptr<DeviceDriver> {
       return std::make_unique<WoodenDriver>(std::move(transport), options.wooden);
     }},
    {"spacemouse", 0, true,
     [](std::unique_ptr<UsbTransport> transport, const UsbDeviceInfo& info,
        const DriverOptions& options) -> std::unique_ptr<DeviceDriver> {
       return std::make_unique<SpaceMouseDriver>(std::move(transport), *FindSpaceMouse(info), options.spacemouse);
     }},
};

const UsbKind& FindUsbKind(const KnownDevice& known) {
  for (const UsbKind& kind : kUsbKinds) {
    if (kind.name == known.name) return kind;
  }
  throw Error(fmt::format("{} is not a USB device", known.name));
}

/// A kind of device on the network.
struct NetworkKind {
  const char* name;
  std::string (*where)(const DriverOptions& options);
  /// `quick`: true for a short timeout, used to find out whether the device is present.
  std::unique_ptr<DeviceDriver> (*make)(const DriverOptions& options, bool quick);
  /// Parts of the driver's message which show that no program, or a different program, listens at the address.
  std::array<const char*, 2> absent;
  const char* remedy;
};

constexpr NetworkKind kNetworkKinds[] = {
    {"bridge",
     [](const DriverOptions& options) { return fmt::format("{}:{}", options.bridge.address, options.bridge.port); },
     [](const DriverOptions& options, bool quick) -> std::unique_ptr<DeviceDriver> {
       BridgeOptions bridge = options.bridge;
       if (quick) bridge.start_timeout_ms = std::min(bridge.start_timeout_ms, options.probe_timeout_ms);
       return MakeBridgeDriver(bridge);
     },
     {"no bridge program is listening", "no bridge program is listening"},
     "End the bridge program and start it again (docs/bridge.md)."},
    {"inverse3",
     [](const DriverOptions& options) { return fmt::format("ws://{}:{}", options.haply.address, options.haply.port); },
     [](const DriverOptions& options, bool quick) -> std::unique_ptr<DeviceDriver> {
       HaplyOptions haply = options.haply;
       if (quick) haply.start_timeout_ms = std::min(haply.start_timeout_ms, options.probe_timeout_ms);
       return MakeHaplyDriver(haply);
     },
     {"no Haply service is listening", "does not speak the JSON of Haply"},
     "Check that Haply's own program shows the Inverse3, and restart its service (docs/wooden.md)."},
};

const NetworkKind* FindNetworkKind(const KnownDevice& known) {
  const auto* found = std::find_if(std::begin(kNetworkKinds), std::end(kNetworkKinds),
                                   [&](const NetworkKind& kind) { return kind.name == known.name; });
  return found == std::end(kNetworkKinds) ? nullptr : found;
}

std::vector<KnownDevice> MakeKnownDevices() {
  std::vector<KnownDevice> devices;
  devices.push_back({"falcon", "Novint Falcon", "USB", true, {{kFalconVendor, kFalconProduct}}});
  devices.push_back({"wooden", "WoodenHaptics", "USB HID", true, {{kWoodenVendor, kWoodenProduct}}});
  KnownDevice mouse{"spacemouse", "3Dconnexion SpaceMouse", "USB HID", false, {}};
  for (const SpaceMouseModel& model : SpaceMouseModels()) mouse.numbers.push_back({model.vendor, model.product});
  devices.push_back(std::move(mouse));
  devices.push_back({"bridge", "a device behind a bridge program that uses its maker's library", "UDP", true, {}});
  devices.push_back({"inverse3", "Haply Inverse3, behind its maker's service", "WebSocket", true, {}});
  return devices;
}

/// Returns the kind with this USB ID, without further checks.
const KnownDevice* FindKind(const UsbDeviceInfo& info) {
  for (const KnownDevice& known : KnownDevices()) {
    for (const UsbNumbers& numbers : known.numbers) {
      if (numbers.vendor == info.vendor && numbers.product == info.product) return &known;
    }
  }
  return nullptr;
}

std::string DescribeNumbers(const UsbDeviceInfo& info) {
  return fmt::format("{:04x}:{:04x}", info.vendor, info.product);
}

/// Sets the reason why the device could not be opened, and the remedy.
void Explain(const UsbOpening& opening, FoundDevice& found) {
  found.problem = opening.detail;
  switch (opening.problem) {
    case UsbProblem::kNoPermission:
      found.state = DeviceState::kNoPermission;
      found.problem = fmt::format("{} can't be opened by this user", DeviceNode(found.usb));
      found.remedy =
          fmt::format("Install kerf's udev rules, then unplug the device and plug it in again: {}", kInstallRules);
      return;
    case UsbProblem::kBusy:
      found.state = DeviceState::kBusy;
      found.remedy = fmt::format(
          "End the program that uses it; 'sudo fuser -v {0}' names it. If it is a kernel driver, "
          "'echo -n {1}:1.0 | sudo tee /sys/bus/usb/devices/{1}:1.0/driver/unbind' detaches it.",
          DeviceNode(found.usb), found.usb.ports.empty() ? "PORT" : found.usb.ports);
      return;
    case UsbProblem::kGone:
      found.state = DeviceState::kFailed;
      found.remedy = "Plug it in again.";
      return;
    case UsbProblem::kNone:
    case UsbProblem::kOther:
      break;
  }
  found.state = DeviceState::kFailed;
  found.remedy = "Unplug the device, wait a few seconds and plug it in again.";
}

/// Returns false for a different gadget that uses the same USB ID.
bool LooksLike(const KnownDevice& known, const UsbDeviceInfo& info) {
  return !FindUsbKind(known).is_hid || info.is_hid;
}

void TryToStart(UsbBus& bus, const DriverOptions& options, FoundDevice& found) {
  const UsbKind& kind = FindUsbKind(*found.kind);
  if (!LooksLike(*found.kind, found.usb)) {
    found.state = DeviceState::kOtherGadget;
    found.problem = fmt::format("has the USB ID {} but no HID interface", DescribeNumbers(found.usb));
    found.remedy = "It is another device with the same USB ID, and kerf does not use it.";
    return;
  }
  UsbOpening opening = bus.Open(found.usb, kind.interface_number);
  if (!opening.transport) {
    Explain(opening, found);
    return;
  }
  try {
    const std::unique_ptr<DeviceDriver> driver = kind.make(std::move(opening.transport), found.usb, options);
    driver->Start({});
    driver->Stop();
  } catch (const Error& error) {
    const bool falcon = found.kind->name == "falcon";
    const std::string what = error.what();
    found.problem = what;
    if (falcon && options.falcon.firmware.empty() && what.find("no firmware") != std::string::npos) {
      found.state = DeviceState::kNoFirmware;
      found.problem = "it has no firmware: a program must load the firmware before the device works";
      found.remedy = fmt::format(
          "Provide the maker's firmware file, which kerf may not distribute, with {} or the environment variable {}; "
          "docs/falcon.md describes where to find it.",
          kFalconFirmwareOption, kFalconFirmwareVariable);
    } else if (what.find("other gadgets") != std::string::npos) {
      found.state = DeviceState::kOtherGadget;
      found.remedy = "kerf does not use it.";
    } else {
      found.state = DeviceState::kFailed;
      found.remedy = "Unplug the device, wait a few seconds, plug it in again and run 'kerf devices' again.";
    }
  }
}

/// Splits "falcon@1-2" into the kind and the port. The port is "" if none is given.
std::pair<std::string, std::string> SplitChoice(const std::string& choice) {
  const std::size_t at = choice.find('@');
  if (at == std::string::npos) return {choice, ""};
  return {choice.substr(0, at), choice.substr(at + 1)};
}

std::vector<FoundDevice> ListKnown(UsbBus& bus) {
  std::vector<FoundDevice> devices;
  for (const UsbDeviceInfo& info : bus.List()) {
    const KnownDevice* kind = FindKind(info);
    if (kind == nullptr) continue;
    FoundDevice found;
    found.kind = kind;
    const SpaceMouseModel* mouse = FindSpaceMouse(info);
    found.model = mouse != nullptr ? mouse->name : kind->what;
    found.usb = info;
    found.where = fmt::format("{} ({})", info.ports, DescribeNumbers(info));
    devices.push_back(std::move(found));
  }
  for (FoundDevice& found : devices) {
    const auto same = [&](const FoundDevice& other) { return other.kind == found.kind; };
    const bool alone = std::count_if(devices.begin(), devices.end(), same) == 1;
    found.choice = alone ? found.kind->name : fmt::format("{}@{}", found.kind->name, found.usb.ports);
  }
  return devices;
}

}  // namespace

std::string DeviceNode(const UsbDeviceInfo& device) {
  return fmt::format("/dev/bus/usb/{:03}/{:03}", device.bus, device.address);
}

const std::vector<KnownDevice>& KnownDevices() {
  static const std::vector<KnownDevice> devices = MakeKnownDevices();
  return devices;
}

const char* ToString(DeviceState state) {
  switch (state) {
    case DeviceState::kReady:
      return "ready";
    case DeviceState::kNoPermission:
      return "no_permission";
    case DeviceState::kBusy:
      return "busy";
    case DeviceState::kNoFirmware:
      return "no_firmware";
    case DeviceState::kOtherGadget:
      return "other_gadget";
    case DeviceState::kFailed:
      return "failed";
  }
  return "";
}

const KnownDevice& FindKnownDevice(const std::string& choice) {
  const std::string name = SplitChoice(choice).first;
  std::vector<std::string> names;
  for (const KnownDevice& known : KnownDevices()) {
    if (known.name == name) return known;
    names.push_back(known.name);
  }
  const std::string nearest = FindNearestName(name, names);
  throw Error(fmt::format("no device is called \"{}\"; {}", name,
                          nearest.empty() ? fmt::format("the devices are {}", fmt::join(names, ", "))
                                          : fmt::format("the nearest is \"{}\"", nearest)));
}

std::vector<FoundDevice> FindUsbDevices(UsbBus& bus, const DriverOptions& options) {
  std::vector<FoundDevice> devices = ListKnown(bus);
  for (FoundDevice& found : devices) TryToStart(bus, options, found);
  return devices;
}

std::vector<FoundDevice> FindNetworkDevices(const DriverOptions& options) {
  std::vector<FoundDevice> devices;
  for (const KnownDevice& known : KnownDevices()) {
    const NetworkKind* kind = FindNetworkKind(known);
    if (kind == nullptr) continue;
    FoundDevice found;
    found.kind = &known;
    found.model = known.what;
    found.where = kind->where(options);
    found.choice = known.name;
    try {
      const std::unique_ptr<DeviceDriver> driver = kind->make(options, true);
      driver->Start({});
      driver->Stop();
      if (!driver->profile().name.empty()) found.model = driver->profile().name;
    } catch (const Error& error) {
      const std::string what = error.what();
      const auto reported = [&](const char* phrase) { return what.find(phrase) != std::string::npos; };
      if (std::any_of(kind->absent.begin(), kind->absent.end(), reported)) continue;
      found.state = reported("in use by another") ? DeviceState::kBusy : DeviceState::kFailed;
      found.problem = what;
      found.remedy = kind->remedy;
    }
    devices.push_back(std::move(found));
  }
  return devices;
}

std::vector<FoundDevice> FindDevices(UsbBus& bus, const DriverOptions& options) {
  std::vector<FoundDevice> devices = FindUsbDevices(bus, options);
  for (FoundDevice& found : FindNetworkDevices(options)) devices.push_back(std::move(found));
  return devices;
}

std::unique_ptr<DeviceDriver> OpenDriver(UsbBus& bus, const std::string& choice, const DriverOptions& options) {
  const KnownDevice& known = FindKnownDevice(choice);
  const std::string socket = SplitChoice(choice).second;
  if (const NetworkKind* far = FindNetworkKind(known); far != nullptr) return far->make(options, false);
  const UsbKind& kind = FindUsbKind(known);
  std::optional<FoundDevice> refused;
  for (FoundDevice& found : ListKnown(bus)) {
    if (found.kind != &known || (!socket.empty() && found.usb.ports != socket) || !LooksLike(known, found.usb))
      continue;
    UsbOpening opening = bus.Open(found.usb, kind.interface_number);
    if (opening.transport) return kind.make(std::move(opening.transport), found.usb, options);
    Explain(opening, found);
    if (!refused) refused = std::move(found);
  }
  if (refused) {
    throw Error(fmt::format("the {} at {} can't be opened: {}. {}", refused->model, refused->usb.ports,
                            refused->problem, refused->remedy));
  }
  throw DeviceNotThere(fmt::format("no {} is plugged in{}; 'kerf devices' lists the connected devices", known.what,
                                   socket.empty() ? "" : fmt::format(" at {}", socket)));
}

std::string MakeUdevRules() {
  std::string rules = fmt::format(
      "# Lets the user logged in at this machine, and members of plugdev, use the haptic devices that kerf supports.\n"
      "# Install: {}\n"
      "# Then unplug the device and plug it in again.\n",
      kInstallRules);
  for (const KnownDevice& known : KnownDevices()) {
    if (known.numbers.empty()) continue;
    rules += fmt::format("\n# {}\n", known.what);
    for (const UsbNumbers& numbers : known.numbers) {
      rules += fmt::format(
          "SUBSYSTEM==\"usb\", ENV{{DEVTYPE}}==\"usb_device\", ATTR{{idVendor}}==\"{:04x}\", "
          "ATTR{{idProduct}}==\"{:04x}\", MODE=\"0660\", GROUP=\"plugdev\", TAG+=\"uaccess\"\n",
          numbers.vendor, numbers.product);
    }
  }
  return rules;
}

}  // namespace kerf
