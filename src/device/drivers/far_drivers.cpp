#include "device/drivers/far_drivers.h"

namespace kerf {

std::unique_ptr<DeviceDriver> MakeBridgeDriver(const BridgeOptions& options) {
  return std::make_unique<BridgeDriver>(options);
}

std::unique_ptr<DeviceDriver> MakeHaplyDriver(const HaplyOptions& options) {
  return std::make_unique<HaplyDriver>(options);
}

}  // namespace kerf
