// libusb without anything behind it: whatever this machine has, or nothing.
#include "drivers/libusb_bus.h"

#include <gtest/gtest.h>

namespace kerf {
namespace {

TEST(LibusbBusWithoutDevices, ListsWithoutFailing) {
  LibusbBus bus;
  for (const UsbDeviceInfo& device : bus.List()) EXPECT_GT(device.address, 0);
}

TEST(LibusbBusWithoutDevices, WhatIsNotThereIsGone) {
  LibusbBus bus;
  const UsbOpening opening = bus.Open({.vendor = 0x1209, .product = 1, .bus = 250, .address = 250}, 0);
  EXPECT_FALSE(opening.transport);
  EXPECT_EQ(opening.problem, UsbProblem::kGone);
}

TEST(LibusbBusWithoutDevices, NamesTheFileOfADevice) {
  EXPECT_EQ(DeviceNode({.bus = 1, .address = 4}), "/dev/bus/usb/001/004");
}

}  // namespace
}  // namespace kerf
