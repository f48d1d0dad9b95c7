// Stand-ins for real devices in a build without libusb and sockets.
#include "base/core/not_built.h"
#include "device/drivers/far_drivers.h"
#include "device/drivers/libusb_bus.h"

namespace kerf {
namespace {

[[noreturn]] void Fail() {
  FailNotBuilt("haptic devices", "KERF_WITH_DEVICES");
}

}  // namespace

std::vector<UsbDeviceInfo> LibusbBus::List() {
  Fail();
}
UsbOpening LibusbBus::Open(const UsbDeviceInfo&, int) {
  Fail();
}
std::unique_ptr<DeviceDriver> MakeBridgeDriver(const BridgeOptions&) {
  Fail();
}
std::unique_ptr<DeviceDriver> MakeHaplyDriver(const HaplyOptions&) {
  Fail();
}

}  // namespace kerf
