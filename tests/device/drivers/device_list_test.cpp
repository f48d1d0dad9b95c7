// The list of available devices, tested with a USB bus that is simulated within the process.
#include "device/drivers/device_list.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <set>

#include "device/drivers/child_process.h"
#include "device/drivers/haply_service.h"
#include "device/emulated/echo_model.h"
#include "device/emulation/falcon_model.h"
#include "device/emulation/model_bus.h"
#include "device/emulation/spacemouse_model.h"
#include "device/emulation/wooden_model.h"
#include "kerf/error.h"
#include "test_paths.h"

namespace kerf {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

std::string Refusal(UsbBus& bus, const std::string& choice) {
  try {
    OpenDriver(bus, choice, {});
  } catch (const Error& error) {
    return error.what();
  }
  return "opened";
}

FalconModelOptions Loaded() {
  FalconModelOptions options;
  options.firmware_is_there = true;
  return options;
}

TEST(DeviceList, FindsEachKindAndOpensIt) {
  PrescribedMechanism held;
  FalconModel falcon(held, Loaded());
  WoodenModel wooden(held);
  SpaceMouseEmulation mouse;
  test::EchoModel other;
  ModelBus bus;
  bus.PlugIn(falcon);
  bus.PlugIn(other);
  bus.PlugIn(wooden);
  bus.PlugIn(mouse);
  const std::vector<FoundDevice> found = FindUsbDevices(bus);
  ASSERT_EQ(found.size(), 3U);
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].choice, KnownDevices()[i].name);
    EXPECT_EQ(found[i].state, DeviceState::kReady) << found[i].problem;
    EXPECT_EQ(found[i].problem, "");
    EXPECT_EQ(found[i].remedy, "");
    const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus, found[i].choice, {});
    EXPECT_EQ(driver->traits().makes_force, found[i].kind->makes_force);
  }
  EXPECT_EQ(found[2].model, "SpaceNavigator");
}

TEST(DeviceList, DistinguishesDevicesOfOneKindByTheirPorts) {
  PrescribedMechanism held;
  FalconModel first(held, Loaded());
  FalconModel second(held, {});
  ModelBus bus;
  bus.PlugIn(first);
  bus.PlugIn(second);
  const std::vector<FoundDevice> found = FindUsbDevices(bus);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].choice, "falcon@1-1");
  EXPECT_EQ(found[1].choice, "falcon@1-2");
  EXPECT_EQ(found[0].state, DeviceState::kReady);
  EXPECT_EQ(found[1].state, DeviceState::kNoFirmware);
  EXPECT_NO_THROW(OpenDriver(bus, "falcon@1-2", {}));
  EXPECT_EQ(Refusal(bus, "falcon@1-7"),
            "no Novint Falcon is plugged in at 1-7; 'kerf devices' lists the connected devices");
}

/// A gadget with the ids of WoodenHaptics but reports of a different size, as other mbed boards may have.
class Gadget : public UsbModel {
 public:
  explicit Gadget(bool hid) : echo_({.vendor = 0x1234, .product = 6, .hid = hid}) {}
  std::vector<std::uint8_t> descriptors() const override { return echo_.descriptors(); }
  void Advance(double /*dt_s*/) override {}
  Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t /*index*/,
                   std::span<std::uint8_t> data) override {
    if (request_type != 0x81 || request != 6 || value != 0x2200) return {TransferEnd::kStall, 0};
    // Vendor-defined usage page; 64 bytes in, 64 bytes out.
    constexpr std::uint8_t kReports[] = {0x06, 0,    0xff, 0x09, 1, 0xa1, 1, 0x75, 8, 0x95,
                                         64,   0x09, 1,    0x81, 2, 9,    1, 0x91, 2, 0xc0};
    const std::size_t bytes = std::min(data.size(), std::size(kReports));
    std::copy_n(kReports, bytes, data.begin());
    return {TransferEnd::kOk, static_cast<int>(bytes)};
  }
  Transfer Write(std::uint8_t /*endpoint*/, std::span<const std::uint8_t> data) override {
    written += static_cast<int>(data.size());
    return {TransferEnd::kOk, static_cast<int>(data.size())};
  }
  Transfer Read(std::uint8_t /*endpoint*/, std::span<std::uint8_t> /*data*/) override {
    return {TransferEnd::kTimeout, 0};
  }
  void PowerOn() override {}

  int written = 0;

 private:
  test::EchoModel echo_;
};

TEST(DeviceList, IgnoresGadgetsWithTheSameIds) {
  for (const bool hid : {false, true}) {
    Gadget gadget(hid);
    ModelBus bus;
    bus.PlugIn(gadget);
    const std::vector<FoundDevice> found = FindUsbDevices(bus);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].state, DeviceState::kOtherGadget) << found[0].problem;
    EXPECT_THAT(found[0].remedy, HasSubstr("does not use it"));
    EXPECT_EQ(gadget.written, 0);
  }
}

TEST(DeviceList, ReportsEachProblemWithItsRemedy) {
  PrescribedMechanism held;
  FalconModel falcon(held, {});
  ModelBus bus;
  EXPECT_EQ(Refusal(bus, "falcon"), "no Novint Falcon is plugged in; 'kerf devices' lists the connected devices");
  bus.PlugIn(falcon);
  struct Case {
    UsbProblem problem;
    DeviceState state;
    const char* remedy;
  };
  for (const Case& c : {Case{UsbProblem::kNoPermission, DeviceState::kNoPermission, "/etc/udev/rules.d/70-kerf.rules"},
                        Case{UsbProblem::kBusy, DeviceState::kBusy, "fuser -v /dev/bus/usb/001/002"},
                        Case{UsbProblem::kGone, DeviceState::kFailed, "Plug it in again."},
                        Case{UsbProblem::kOther, DeviceState::kFailed, "plug it in again"}}) {
    bus.SetProblem(c.problem);
    const std::vector<FoundDevice> found = FindUsbDevices(bus);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].state, c.state);
    EXPECT_THAT(found[0].remedy, HasSubstr(c.remedy));
    EXPECT_THAT(Refusal(bus, "falcon"), StartsWith("the Novint Falcon at 1-1 can't be opened: "));
  }
}

TEST(DeviceList, SilentDevicesAreReportedAsFailed) {
  PrescribedMechanism held;
  FalconModel falcon(held, Loaded());
  WoodenModel wooden(held);
  ModelBus bus;
  bus.PlugIn(falcon);
  bus.PlugIn(wooden);
  UsbFaults faults;
  faults.stalled = true;
  bus.SetFaults(faults);
  const std::vector<FoundDevice> found = FindUsbDevices(bus);
  ASSERT_EQ(found.size(), 2U);
  // The device looks like one without firmware, and loading the firmware may fix it.
  EXPECT_EQ(found[0].state, DeviceState::kNoFirmware);
  EXPECT_EQ(found[1].state, DeviceState::kFailed);
  EXPECT_THAT(found[1].problem, HasSubstr("no reports"));
}

/// Options with long waits, for a busy machine. Haply's service answers at once or never, so that a failed start takes
/// the full timeout.
DriverOptions MakePatientOptions() {
  DriverOptions options;
  options.probe_timeout_ms = 10'000;
  options.bridge.start_timeout_ms = options.probe_timeout_ms;
  options.haply.start_timeout_ms = 2000;
  return options;
}

TEST(DeviceList, BridgesAreListedWhenTheyAnswer) {
  DriverOptions options = MakePatientOptions();
  {
    test::ChildProcess example({KERF_BRIDGE_EXAMPLE, "0"});
    const std::string line = example.ReadLine();
    const test::HaplyService other(test::HaplyService::Mood::kGarbage);  // a service of another kind
    options.haply.port = other.port();
    options.bridge.port = static_cast<std::uint16_t>(std::stoi(line.substr(line.rfind(':') + 1)));
    const std::vector<FoundDevice> found = FindNetworkDevices(options);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind->name, "bridge");
    EXPECT_EQ(found[0].state, DeviceState::kReady) << found[0].problem;
    EXPECT_EQ(found[0].where, "127.0.0.1:" + std::to_string(options.bridge.port));
    EXPECT_NE(found[0].model, "bridge");  // the name that the bridge reports
    ModelBus bus;
    EXPECT_TRUE(OpenDriver(bus, "bridge", options));
    example.End(SIGTERM);
  }
  EXPECT_TRUE(FindNetworkDevices(options).empty());
}

TEST(DeviceList, HaplysServiceIsListedEvenWithoutAnInverse3) {
  DriverOptions options = MakePatientOptions();
  options.bridge.port = 1;  // a port without a service
  test::HaplyService service;
  options.haply.port = service.port();
  const std::vector<FoundDevice> found = FindNetworkDevices(options);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].kind->name, "inverse3");
  EXPECT_EQ(found[0].state, DeviceState::kReady) << found[0].problem;
  const test::HaplyService empty(test::HaplyService::Mood::kNoDevice);
  options.haply.port = empty.port();
  const std::vector<FoundDevice> none = FindNetworkDevices(options);
  ASSERT_EQ(none.size(), 1U);
  EXPECT_EQ(none[0].state, DeviceState::kFailed);
  EXPECT_THAT(none[0].problem, HasSubstr("lists no Inverse3"));
  EXPECT_THAT(none[0].remedy, HasSubstr("Haply's own program"));
}

TEST(DeviceList, UnknownNameIsReportedWithTheNearest) {
  ModelBus bus;
  EXPECT_EQ(Refusal(bus, "falkon"), "no device is called \"falkon\"; the nearest is \"falcon\"");
  EXPECT_THAT(Refusal(bus, "x"), StartsWith("no device is called \"x\"; the devices are falcon, wooden, spacemouse"));
  EXPECT_EQ(FindKnownDevice("wooden@1-3").name, "wooden");
}

// The rules contain each device's ids once, and no others.
TEST(DeviceList, RulesForUdevNameEachDeviceOnce) {
  const std::string rules = MakeUdevRules();
  std::set<std::string> seen;
  for (const KnownDevice& known : KnownDevices()) {
    for (const UsbNumbers& numbers : known.numbers) {
      char pair[80];
      std::snprintf(pair, sizeof(pair), "ATTR{idVendor}==\"%04x\", ATTR{idProduct}==\"%04x\"", numbers.vendor,
                    numbers.product);
      EXPECT_THAT(rules, HasSubstr(pair));
      EXPECT_TRUE(seen.insert(pair).second) << pair;
    }
  }
  std::size_t lines = 0;
  for (std::size_t at = rules.find("SUBSYSTEM"); at != std::string::npos; at = rules.find("SUBSYSTEM", at + 1)) ++lines;
  EXPECT_EQ(lines, seen.size());
  EXPECT_EQ(rules.back(), '\n');
}

}  // namespace
}  // namespace kerf
