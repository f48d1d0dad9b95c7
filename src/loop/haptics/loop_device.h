// A real device, which replaces the simulated device and hand.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "kerf/coupled.h"
#include "kerf/device.h"

namespace kerf {

/// Real device for a loop. Its capabilities are those in the scene's [device] section.
struct LoopDevice {
  /// Called after the bone has been made and before the first tick, with the tool's pose and the coupling between the
  /// device and the tool. `force_scale`: device N per simulated N. May wait for the user. May throw kerf::Error. Empty:
  /// no device.
  std::function<Device&(const Pose& X_WT, const CouplingParams& coupling, double force_scale)> begin;
  /// Returns statistics of the device after the loop has ended: names with units, and values. Optional.
  std::function<std::vector<std::pair<std::string, double>>()> figures;
  bool in_real_time = true;  // false: its time advances in Elapse(), so it can also be used without a clock
  bool is_set() const { return static_cast<bool>(begin); }
};

}  // namespace kerf
