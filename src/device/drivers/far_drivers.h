// Drivers of devices connected over the network.
#pragma once

#include <memory>

#include "device/devices/driver.h"
#include "device/drivers/bridge_driver.h"
#include "device/drivers/haply_driver.h"

namespace kerf {

std::unique_ptr<DeviceDriver> MakeBridgeDriver(const BridgeOptions& options);
std::unique_ptr<DeviceDriver> MakeHaplyDriver(const HaplyOptions& options);

}  // namespace kerf
