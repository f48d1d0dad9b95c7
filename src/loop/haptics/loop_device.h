// A device in place of the simulated one with a hand on it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "device/devices/device.h"
#include "kerf/coupled.h"

namespace kerf {

/// The scene's [device] says what it can do.
struct LoopDevice {
  /// When the bone is made, before the first tick: where the tool stands, and the coupling by which the device holds it
  /// (`force_scale`: device N per N of it). May wait for somebody. Throws Error. Empty: there is none.
  std::function<Device&(const Pose& X_WT, const CouplingParams& coupling, double force_scale)> begin;
  /// What it has been through, after the loop: names with units. May be empty.
  std::function<std::vector<std::pair<std::string, double>>()> figures;
  bool in_real_time = true;  // false: it goes by what Elapse() tells it, so a run without the clock can have it too
  bool is_there() const { return static_cast<bool>(begin); }
};

}  // namespace kerf
