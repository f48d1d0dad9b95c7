// Loss of force when a device is weaker than the simulated force.
#pragma once

#include <vector>

#include "kerf/device.h"

namespace kerf {

/// Largest simulated force.
inline constexpr Range kExpectedPeakRange_N{0.1, 1e4};

/// Forces are in simulated newtons unless stated otherwise.
struct ForceTableRow {
  DeviceProfile profile;
  double scale = 1;      // device N per simulated N: peak force / expected force, at most 1
  double largest_N = 0;  // largest force that reaches the hand without being limited
  double masked_N = 0;   // smaller forces are hidden by the device's friction; 0 if there is none or it is unknown
  double lasting_N = 0;  // force that the device can output continuously; 0 if unknown
  double lasting_fraction = 0;  // lasting_N / largest_N, 0 to 1; 0 if unknown
  double range = 0;             // largest_N / masked_N; 0 if no force is masked
};

/// Computes one row per profile, in the same order. `expected_N` is the largest simulated force.
/// Throws kerf::Error if it is out of range.
std::vector<ForceTableRow> CalcForceTable(const std::vector<DeviceProfile>& profiles, double expected_N);

}  // namespace kerf
