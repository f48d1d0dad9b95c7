// A plugged-in Falcon and a driver that has opened it, for the tests of the Falcon.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "device/devices/falcon/falcon_driver.h"
#include "device/devices/falcon/falcon_usb.h"
#include "device/emulation/falcon_model.h"
#include "device/emulation/model_bus.h"

namespace kerf {

inline constexpr double kFalconDt_s = 0.001;

/// Returns made-up firmware.
inline std::vector<std::uint8_t> MakeFalconFirmware(std::size_t bytes = 7324) {
  std::mt19937 random(3);
  std::vector<std::uint8_t> firmware(bytes);
  for (std::uint8_t& byte : firmware) byte = static_cast<std::uint8_t>(random());
  return firmware;
}

inline FalconModelOptions RunningFalcon() {
  FalconModelOptions options;
  options.firmware_is_there = true;
  options.homed = true;
  return options;
}

inline FalconModelOptions EmptyFalcon() {
  FalconModelOptions options;
  options.firmware = MakeFalconFirmware();
  return options;
}

/// A plugged-in Falcon and a driver that has opened it.
struct FalconBench {
  explicit FalconBench(FalconModelOptions model_options = RunningFalcon(), FalconOptions driver_options = {})
      : model(handle, std::move(model_options)) {
    bus.PlugIn(model);
    driver = Open(std::move(driver_options));
  }

  std::unique_ptr<FalconDriver> Open(FalconOptions options) {
    const std::vector<UsbDeviceInfo> devices = bus.List();
    EXPECT_EQ(devices.size(), 1U);
    UsbOpening opening = bus.Open(devices.at(0), kFalconInterface);
    EXPECT_TRUE(opening.transport);
    return std::make_unique<FalconDriver>(std::move(opening.transport), std::move(options));
  }

  void MoveTo(const Vec3& p_D_mm) {
    handle.X_DH.p_AB = p_D_mm;
    bus.Advance(kFalconDt_s);
  }

  RoundEnd Round(const Vec3& f_D_N = Vec3{0}) {
    DriverCommand command;
    command.f_D_N = f_D_N;
    command.engaged = true;
    return driver->Exchange(command, sample);
  }

  /// Runs rounds until the driver has a position.
  void Settle() {
    for (int i = 0; i < 10 && Round() != RoundEnd::kSample; ++i) {
    }
    ASSERT_EQ(Round(), RoundEnd::kSample);
  }

  void Start() { driver->Start({}); }

  PrescribedMechanism handle;
  FalconModel model;
  ModelBus bus;
  std::unique_ptr<FalconDriver> driver;
  DriverSample sample;
};

inline FalconOptions WithFalconFirmware() {
  FalconOptions options;
  options.firmware = MakeFalconFirmware();
  return options;
}

/// Largest motion of the grip for half a count on each leg.
inline constexpr double kHalfCount_mm = 0.06;

}  // namespace kerf
