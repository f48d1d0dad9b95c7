// The devices that can be emulated, by name, with the hand that holds them.
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
  std::vector<std::uint8_t> firmware;  // that a Falcon runs, and no other; empty: any
  bool firmware_is_there = false;      // since before
  bool homed = false;                  // and homed
  int wrong_echoes = 0;                // uploads that go wrong
};

/// A device's model and what its user would see of it. Its calls are for who holds the models still
/// (EmulatedKernel::Look).
class EmulatedDevice {
 public:
  EmulatedDevice() = default;
  EmulatedDevice(const EmulatedDevice&) = delete;
  EmulatedDevice& operator=(const EmulatedDevice&) = delete;
  virtual ~EmulatedDevice() = default;

  virtual UsbModel& model() = 0;
  /// A program exchanges with it: time for the hand to begin.
  virtual bool driven() const = 0;
  /// Packets that the program has sent to it so far, firmware left out.
  virtual std::uint64_t packets() const { return 0; }
  virtual bool wants_homing() const { return false; }
  /// Its lamps say that the hand has the tool; that it is ready, and waits for the user to agree.
  virtual bool engaged() const { return false; }
  virtual bool waits() const { return false; }
  /// What the hand does to a device without a mechanism that would move it: dt_s have gone by.
  virtual void Follow(Mechanism& /*hand*/, double /*dt_s*/) {}
  /// What it has been through.
  virtual nlohmann::ordered_json Report() const = 0;
};

/// falcon, wooden or spacemouse; the mechanism must outlive it. Throws Error that names those there are.
std::unique_ptr<EmulatedDevice> MakeEmulatedDevice(const std::string& name, Mechanism& mechanism,
                                                   const EmulatedDeviceOptions& options);
const std::vector<std::string>& NamesOfEmulatedDevices();

}  // namespace kerf::test
