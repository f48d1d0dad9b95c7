// The drivers with the real libusb and with models of the devices behind an emulated kernel.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "device/devices/falcon/falcon_driver.h"
#include "device/drivers/device_list.h"
#include "device/drivers/libusb_bus.h"
#include "device/emulated/emulated_kernel.h"
#include "device/emulation/falcon_model.h"
#include "device/emulation/spacemouse_model.h"
#include "device/emulation/wooden_model.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using test::EmulatedKernel;
using testing::HasSubstr;

/// Returns made-up firmware with the size of real firmware.
std::vector<std::uint8_t> MakeFirmware() {
  std::vector<std::uint8_t> bytes(7324);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 31 + (i >> 7));
  return bytes;
}

/// Number of exchanges by result.
struct Count {
  int samples = 0;
  int no_answer = 0;
  int bad = 0;
  int gone = 0;
};

/// Makes exchanges at about 1 kHz; the timing is not tested.
Count ExchangeFor(DeviceDriver& driver, int rounds, const std::function<void(const DriverSample&)>& look = {},
                  const DriverCommand& command = {}) {
  Count count;
  auto next = std::chrono::steady_clock::now();
  for (int i = 0; i < rounds && count.gone == 0; ++i) {
    next += std::chrono::milliseconds(1);
    std::this_thread::sleep_until(next);
    DriverSample sample;
    switch (driver.Exchange(command, sample)) {
      case RoundEnd::kSample:
        ++count.samples;
        if (look) look(sample);
        break;
      case RoundEnd::kNoAnswer:
        ++count.no_answer;
        break;
      case RoundEnd::kBadAnswer:
        ++count.bad;
        break;
      case RoundEnd::kGone:
        ++count.gone;
        break;
    }
  }
  return count;
}

class EmulatedDrivers : public testing::Test {
 protected:
  EmulatedDrivers() { options_.falcon.timeout_ms = 1000; }

  PrescribedMechanism held_;
  LibusbBus bus_;
  DriverOptions options_;
};

TEST_F(EmulatedDrivers, FalconTakesItsFirmwareByteForByte) {
  FalconModelOptions model_options;
  model_options.firmware = MakeFirmware();
  model_options.wrong_echoes = 1;  // the first upload fails
  FalconModel model(held_, model_options);
  EmulatedKernel kernel;
  kernel.PlugIn(model);
  options_.falcon.firmware = MakeFirmware();
  const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "falcon", options_);
  double last = 0;
  driver->Start([&](const std::string&, double fraction) {
    last = fraction;
    return true;
  });
  kernel.Look([&] {
    EXPECT_EQ(model.loaded(), MakeFirmware());
    EXPECT_TRUE(model.runs());
    EXPECT_EQ(model.uploads(), 2);
  });
  EXPECT_GT(last, 0);
  EXPECT_EQ(kernel.unknown_calls(), 0);
}

TEST_F(EmulatedDrivers, FalconIsHomedAndReportsItsGripPosition) {
  FalconModelOptions model_options;
  model_options.firmware_is_there = true;
  FalconModel model(held_, model_options);
  EmulatedKernel kernel;
  kernel.PlugIn(model);
  const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "falcon", options_);
  driver->Start({});
  bool homed = false;
  const auto look = [&](const DriverSample& sample) { homed = sample.homed; };
  ExchangeFor(*driver, 20, look);
  EXPECT_FALSE(homed);
  for (const double z_mm : {42.0, -38.0}) {
    kernel.Look([&] { held_.X_DH.p_AB = Vec3(0, 0, z_mm); });
    ExchangeFor(*driver, 20, look);
  }
  EXPECT_TRUE(homed);
  const Vec3 wanted(5, -7, 3);
  kernel.Look([&] {
    held_.X_DH.p_AB = wanted;
    held_.pressed = 4;
  });
  DriverSample last;
  ExchangeFor(*driver, 20, [&](const DriverSample& sample) { last = sample; });
  // One count of a leg is 0.04 mm at the grip.
  EXPECT_LT(glm::length(last.X_DH.p_AB - wanted), 0.1);
  EXPECT_EQ(last.buttons, 4U);
}

TEST_F(EmulatedDrivers, FalconExchangesAtAThousandHertzWithoutBadAnswers) {
  FalconModelOptions model_options;
  model_options.firmware_is_there = true;
  model_options.homed = true;
  FalconModel model(held_, model_options);
  EmulatedKernel kernel;
  kernel.PlugIn(model);
  const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "falcon", options_);
  driver->Start({});
  ExchangeFor(*driver, 10);  // the first report is rejected
  DriverCommand command;
  command.f_D_N = Vec3(1, -0.5, 0.25);
  const Count count = ExchangeFor(*driver, 3000, {}, command);
  EXPECT_EQ(count.samples, 3000);
  EXPECT_EQ(count.bad, 0);
  EXPECT_EQ(count.no_answer, 0);
  kernel.Look([&] {
    // The error is half a count of each motor, 0.05 N mm on legs of 60 mm.
    EXPECT_LT(glm::length(held_.f_D_N() - command.f_D_N), 0.01);
    EXPECT_FALSE(model.saw_homing_off());
    EXPECT_GE(model.commands(), 3000U);
  });
  driver->Stop();
  kernel.Look([&] {
    model.Advance(1e-3);
    EXPECT_EQ(held_.f_D_N(), Vec3(0));
  });
}

TEST_F(EmulatedDrivers, FalconIsUnpluggedInMidExchangeAndPluggedInAgain) {
  FalconModelOptions model_options;
  model_options.firmware = MakeFirmware();
  FalconModel model(held_, model_options);
  EmulatedKernel kernel;
  const int socket = kernel.PlugIn(model);
  options_.falcon.firmware = MakeFirmware();
  constexpr int kInTheMiddle = 20;
  for (int time = 0; time < 2; ++time) {
    const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "falcon", options_);
    driver->Start({});
    std::atomic<int> samples{0};
    std::atomic<bool> ended{false};
    std::thread puller([&] {
      while (samples < kInTheMiddle && !ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
      kernel.Unplug(socket);
    });
    const Count count = ExchangeFor(*driver, 10'000, [&](const DriverSample&) { ++samples; });
    ended = true;
    puller.join();
    EXPECT_GE(count.samples, kInTheMiddle);
    EXPECT_EQ(count.gone, 1);
    driver->Stop();  // does no harm without a device
    EXPECT_THROW(OpenDriver(bus_, "falcon", options_), Error);
    kernel.PlugInAgain(socket);
  }
  EXPECT_EQ(FindUsbDevices(bus_, options_).size(), 1U);
}

TEST_F(EmulatedDrivers, SilentFalconGivesNoAnswerAndThenGoesOn) {
  FalconModelOptions model_options;
  model_options.firmware_is_there = true;
  model_options.homed = true;
  FalconModel model(held_, model_options);
  EmulatedKernel kernel;
  const int socket = kernel.PlugIn(model);
  options_.falcon.timeout_ms = 200;
  const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "falcon", options_);
  driver->Start({});
  ExchangeFor(*driver, 10);
  kernel.SetSilent(socket, true);
  const Count silent = ExchangeFor(*driver, 3);
  EXPECT_EQ(silent.no_answer, 3);
  kernel.SetSilent(socket, false);
  const Count again = ExchangeFor(*driver, 50);
  EXPECT_GT(again.samples, 40);
  EXPECT_EQ(again.gone, 0);
}

TEST_F(EmulatedDrivers, WoodenDeviceExchangesReportsByInterrupt) {
  WoodenModel model(held_);
  EmulatedKernel kernel;
  kernel.PlugIn(model, {.driver = "usbhid"});
  const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "wooden", options_);
  driver->Start({});
  const Vec3 wanted(10, 20, -15);
  kernel.Look([&] { held_.X_DH.p_AB = wanted; });
  DriverSample last;
  DriverCommand command;
  command.f_D_N = Vec3(0.5, 1, -0.5);
  // The driver waits at most a millisecond or two. This machine may be slower, but only one report is bad, the one in
  // which the handle jumps.
  const auto look = [&](const DriverSample& sample) { last = sample; };
  Count all;
  for (int part = 0; part < 20 && (part == 0 || all.samples <= 200); ++part) {
    const Count count = ExchangeFor(*driver, 2000, look, command);
    all.samples += count.samples;
    all.bad += count.bad;
    all.gone += count.gone;
  }
  EXPECT_EQ(all.gone, 0);
  EXPECT_LE(all.bad, 1);
  EXPECT_GT(all.samples, 200);
  // One count is 2 pi / 32000, which is 0.1 mm at the handle.
  EXPECT_LT(glm::length(last.X_DH.p_AB - wanted), 0.2);
  // If the machine stalls before the check, the board switches its motors off, and the check is repeated.
  bool on = false;
  for (int tries = 0; tries < 100 && !on; ++tries) {
    ExchangeFor(*driver, 20, look, command);
    kernel.Look([&] {
      on = model.motors_on();
      // Currents are integers in mA; with 26 N mm / A and a gear ratio of 12, 1 mA is 0.3 N mm, which acts on arms of
      // 200 mm.
      if (on) {
        EXPECT_LT(glm::length(held_.f_D_N() - command.f_D_N), 0.05);
      }
    });
  }
  EXPECT_TRUE(on);
}

TEST_F(EmulatedDrivers, SpaceMouseReportsItsDeflection) {
  SpaceMouseEmulation model;
  EmulatedKernel kernel;
  kernel.PlugIn(model, {.driver = "usbhid"});
  const std::unique_ptr<DeviceDriver> driver = OpenDriver(bus_, "spacemouse", options_);
  driver->Start({});
  kernel.Look([&] {
    EXPECT_TRUE(model.lamp());
    model.Push({350, 0, 0, 0, 0, -350});
    model.Press(2);
  });
  DriverSample last;
  for (int part = 0; part < 40 && (part == 0 || last.buttons == 0); ++part) {
    const Count count = ExchangeFor(*driver, 50, [&](const DriverSample& sample) { last = sample; });
    EXPECT_EQ(count.bad, 0);
    EXPECT_EQ(count.gone, 0);
  }
  EXPECT_EQ(last.deflection[0], 1);
  EXPECT_EQ(last.buttons, 2U);
  driver->Stop();
  kernel.Look([&] { EXPECT_FALSE(model.lamp()); });
}

/// Returns the only device that is found.
FoundDevice FindOnly(UsbBus& bus) {
  const std::vector<FoundDevice> found = FindUsbDevices(bus);
  EXPECT_EQ(found.size(), 1U);
  return found.empty() ? FoundDevice{} : found[0];
}

TEST_F(EmulatedDrivers, EachProblemIsReportedWithItsRemedy) {
  FalconModel model(held_, {});
  {
    EmulatedKernel kernel;
    kernel.PlugIn(model);
    const FoundDevice found = FindOnly(bus_);
    EXPECT_EQ(found.state, DeviceState::kNoFirmware);
    EXPECT_THAT(found.remedy, HasSubstr("--falcon-firmware"));
  }
  {
    EmulatedKernel kernel;
    kernel.PlugIn(model, {.no_permission = true});
    const test::WithoutPrivileges limit;
    const FoundDevice found = FindOnly(bus_);
    EXPECT_EQ(found.state, DeviceState::kNoPermission);
    EXPECT_THAT(found.remedy, HasSubstr("kerf devices --udev-rules"));
    try {
      OpenDriver(bus_, "falcon", options_);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr("/dev/bus/usb/001/004 can't be opened by this user"));
      EXPECT_THAT(error.what(), HasSubstr("udevadm"));
    }
  }
  {
    EmulatedKernel kernel;
    kernel.PlugIn(model, {.driver = "cdc_acm"});
    const FoundDevice found = FindOnly(bus_);
    EXPECT_EQ(found.state, DeviceState::kBusy);
    EXPECT_THAT(found.problem, HasSubstr("cdc_acm"));
    EXPECT_THAT(found.remedy, HasSubstr("/sys/bus/usb/devices/1-1:1.0/driver/unbind"));
  }
  {
    EmulatedKernel kernel;
    kernel.PlugIn(model, {.driver = "ftdi_sio"});  // this driver can be detached
    EXPECT_EQ(FindOnly(bus_).state, DeviceState::kNoFirmware);
  }
}

}  // namespace
}  // namespace kerf
