// Checks and computations before the first tick.
#pragma once

#include "kerf/coupled.h"

namespace kerf {

/// Throws Error naming the first value out of range.
void CheckParams(const CoupledParams& params);

/// Returns the pose. Throws Error if it is not valid or not within the world.
Pose MakeStart(const Pose& X_WT);

}  // namespace kerf
