// The steps of a tool along a path, and what its ticks give.
#pragma once

#include <cstddef>

#include "kerf/geometry.h"
#include "kerf/simulation.h"

namespace kerf {

/// A step along a path: a tick, or the placement of the tool at the first pose of a segment.
struct PathStep {
  std::size_t segment = 0;
  bool set_down = false;  // no tick: the tool was lifted and is placed at X_WT
  Pose X_WT;              // tool pose at the end of the step
  double time_s = 0;      // path time at the end of the step
  double dt_s = 0;        // 0 for a placement
};

/// A tick along a path.
struct TickRecord {
  double time_s = 0;  // path time at the end of the tick
  std::size_t segment = 0;
  Pose X_WT;             // at the end of the tick
  double travel_mm = 0;  // path length of the tool's origin since this segment's first contact; 0 before
  bool touched = false;  // the tool has touched bone in this segment
  TickOutput out;
};

}  // namespace kerf
