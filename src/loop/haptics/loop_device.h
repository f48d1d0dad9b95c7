// A device that replaces the simulated device and hand.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "device/devices/device.h"
#include "kerf/coupled.h"

namespace kerf {

/// Real device for a loop. The scene's [device] section describes its capabilities.
struct LoopDevice {
  /// Called after the bone is made and before the first tick, with the tool's pose and the coupling between device and
  /// tool. `force_scale`: device N per simulated N. May wait for the user. Throws kerf::Error. Empty: no device.
  std::function<Device&(const Pose& X_WT, const CouplingParams& coupling, double force_scale)> begin;
  /// Returns statistics of the device after the loop: names with units, and values. Optional.
  std::function<std::vector<std::pair<std::string, double>>()> figures;
  bool in_real_time = true;  // false: its time advances by Elapse(), so it can also be used in a run without a clock
  bool is_there() const { return static_cast<bool>(begin); }
};

}  // namespace kerf
