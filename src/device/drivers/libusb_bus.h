// What is really plugged in, through libusb.
#pragma once

#include <string>
#include <vector>

#include "device/devices/usb.h"

namespace kerf {

/// Each call looks anew, without memory of the last, so that what was plugged in since is there even where no udev
/// runs. Where the system has no USB at all, nothing is plugged in. Any thread.
///
/// A transport that it opens stands on its own, has its own events and is for one thread at a time. A round makes no
/// allocation of ours; libusb makes one for each transfer that it hands to the kernel.
class LibusbBus final : public UsbBus {
 public:
  /// Sorted by bus and address. Throws Error when libusb itself can't begin.
  std::vector<UsbDeviceInfo> List() override;
  /// HID interfaces are taken from usbhid and serial ones from ftdi_sio, and given back at the end; from no other
  /// driver.
  UsbOpening Open(const UsbDeviceInfo& device, int interface_number) override;
};

/// The file of a device that a program must be allowed to write to: "/dev/bus/usb/001/004".
std::string DeviceNode(const UsbDeviceInfo& device);

}  // namespace kerf
