// A USB device made of numbers, exact to what is known of the real one's protocol: what it answers to each transfer.
// The same model stands behind a transport within the process and behind an emulated kernel.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "device/devices/usb.h"

namespace kerf {

class UsbModel {
 public:
  UsbModel() = default;
  UsbModel(const UsbModel&) = delete;
  UsbModel& operator=(const UsbModel&) = delete;
  virtual ~UsbModel() = default;

  /// Device descriptor, then configuration, interface, HID (where it is one) and endpoint descriptors, as a kernel
  /// gives them in /sys/.../descriptors.
  virtual std::vector<std::uint8_t> descriptors() const = 0;
  virtual int bus_speed_mbit() const { return 12; }

  /// Time passes for mechanism, firmware and hand.
  virtual void Advance(double dt_s) = 0;
  /// kStall for a request that the device does not know.
  virtual Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                           std::span<std::uint8_t> data) = 0;
  virtual Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) = 0;
  /// A packet, if there is one now; kTimeout with none: the host goes on waiting.
  virtual Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) = 0;
  /// As after plugging in again: all that it was told is forgotten.
  virtual void PowerOn() = 0;
};

/// Vendor and product of a device descriptor. Throws Error when it is not one.
UsbDeviceInfo ReadDeviceInfo(std::span<const std::uint8_t> descriptors);

}  // namespace kerf
