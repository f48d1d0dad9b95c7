// Tests libusb on this machine, with or without devices.
#include "device/drivers/libusb_bus.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(LibusbBusWithoutDevices, ListsWithoutFailing) {
  LibusbBus bus;
  for (const UsbDeviceInfo& device : bus.List()) EXPECT_GT(device.address, 0);
}

TEST(LibusbBusWithoutDevices, OpeningAnAbsentDeviceReturnsGone) {
  LibusbBus bus;
  UsbDeviceInfo device;
  device.bus = 250;
  device.address = 250;
  const UsbOpening opening = bus.Open(device, 0);
  EXPECT_FALSE(opening.transport);
  EXPECT_EQ(opening.problem, UsbProblem::kGone);
}

TEST(LibusbBusWithoutDevices, NamesTheFileOfADevice) {
  UsbDeviceInfo device;
  device.bus = 1;
  device.address = 4;
  EXPECT_EQ(DeviceNode(device), "/dev/bus/usb/001/004");
}

}  // namespace
}  // namespace kerf
