// What is left of a force on its way to a device that is weaker than it.
#pragma once

#include <vector>

#include "device/devices/device.h"

namespace kerf {

/// All in the simulation's newtons but what is named otherwise.
struct ForceTableRow {
  DeviceProfile profile;
  double scale = 1;          // device N for 1 N of the simulation: peak / expected, never above 1
  double largest_N = 0;      // that reaches the hand unshortened
  double masked_N = 0;       // below this the device's own friction hides it; 0 where there is none, or it is unknown
  double lasting_N = 0;      // that it makes for ever; 0 where unknown
  double lasting_share = 0;  // of the largest, 0 to 1; 0 where unknown
  double range = 0;          // largest / masked; 0 where nothing is masked
};

/// One row for each profile, in their order. `expected_N` is the largest force of the simulation, 0.1 to 1e4. Throws
/// Error when it is out of range.
std::vector<ForceTableRow> CalcForceTable(const std::vector<DeviceProfile>& profiles, double expected_N);

}  // namespace kerf
