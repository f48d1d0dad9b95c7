// USB bus through libusb.
#pragma once

#include <string>
#include <vector>

#include "device/devices/usb.h"

namespace kerf {

/// Each call lists the devices again without a cache, so that new devices are found even without udev. If the system
/// has no USB, the list is empty. May be used by any thread.
///
/// Each transport that it opens is independent, handles its own events and is used by one thread at a time. A round
/// allocates nothing in kerf; libusb allocates for each transfer that it submits to the kernel.
class LibusbBus final : public UsbBus {
 public:
  /// Lists the devices, sorted by bus and address. Throws kerf::Error if libusb cannot be initialised.
  std::vector<UsbDeviceInfo> List() override;
  /// Detaches the kernel driver of an HID interface (usbhid) or of a serial interface (ftdi_sio), and attaches it again
  /// when the interface is closed. Does not detach other kernel drivers.
  UsbOpening Open(const UsbDeviceInfo& device, int interface_number) override;
};

/// Returns the device file to which a program needs write access: "/dev/bus/usb/001/004".
std::string DeviceNode(const UsbDeviceInfo& device);

}  // namespace kerf
