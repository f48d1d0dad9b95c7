// Interface of a software model of a USB device, which follows the known protocol of the real device transfer by
// transfer. The same model is used by a transport within the process and by an emulated kernel.
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

  /// Returns the device descriptor, then configuration, interface, HID (if any) and endpoint descriptors, as the
  /// kernel shows them in /sys/.../descriptors.
  virtual std::vector<std::uint8_t> descriptors() const = 0;
  virtual int bus_speed_mbit() const { return 12; }

  /// Advances the mechanism, the firmware and the hand by dt_s.
  virtual void Advance(double dt_s) = 0;
  /// Returns kStall for a request that the device does not support.
  virtual Transfer Control(std::uint8_t request_type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                           std::span<std::uint8_t> data) = 0;
  virtual Transfer Write(std::uint8_t endpoint, std::span<const std::uint8_t> data) = 0;
  /// Returns a packet if one is available. Otherwise returns kTimeout, and the host continues to wait.
  virtual Transfer Read(std::uint8_t endpoint, std::span<std::uint8_t> data) = 0;
  /// Resets the state, as when the device is plugged in again.
  virtual void PowerOn() = 0;
};

/// Returns the vendor and product in a device descriptor. Throws kerf::Error if the bytes are not a device descriptor.
UsbDeviceInfo ReadDeviceInfo(std::span<const std::uint8_t> descriptors);

}  // namespace kerf
