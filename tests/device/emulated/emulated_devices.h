// The devices that can be emulated, by name, with the hand that holds their handle.
#pragma once

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "device/emulation/mechanism.h"
#include "device/emulation/usb_model.h"

namespace kerf::test {

struct EmulatedDeviceOptions {
  std::vector<std::uint8_t> firmware;  // the only firmware that a Falcon accepts; if empty, it accepts any
  bool firmware_is_there = false;      // the firmware is loaded at the start
  bool homed = false;                  // the device is also homed at the start
  int wrong_echoes = 0;                // number of uploads that fail
};

/// A device's model, and what its user would see. To be called only while the models do not move
/// (EmulatedKernel::Look).
class EmulatedDevice {
 public:
  EmulatedDevice() = default;
  EmulatedDevice(const EmulatedDevice&) = delete;
  EmulatedDevice& operator=(const EmulatedDevice&) = delete;
  virtual ~EmulatedDevice() = default;

  virtual UsbModel& model() = 0;
  /// True while a program exchanges data with the device, so that the hand may begin.
  virtual bool driven() const = 0;
  /// Number of packets that the program has sent to the device so far, not counting the firmware.
  virtual std::uint64_t packets() const { return 0; }
  virtual bool wants_homing() const { return false; }
  /// engaged(): the device's lamps show that the hand has the tool. waits(): the device is ready and waits for the user
  /// to agree.
  virtual bool engaged() const { return false; }
  virtual bool waits() const { return false; }
  /// Moves a device that has no mechanism according to the hand, for the next `dt_s`.
  virtual void Follow(Mechanism& /*hand*/, double /*dt_s*/) {}
  /// Returns a summary of a run.
  virtual nlohmann::ordered_json Report() const = 0;
};

/// `name` is falcon, wooden or spacemouse; for any other name, throws Error with a list of these. The mechanism must
/// outlive the device.
std::unique_ptr<EmulatedDevice> MakeEmulatedDevice(const std::string& name, Mechanism& mechanism,
                                                   const EmulatedDeviceOptions& options);
const std::vector<std::string>& NamesOfEmulatedDevices();

}  // namespace kerf::test
