// Checks and computations before the first tick.
#pragma once

#include "bone/grid/field.h"
#include "kerf/coupled.h"

namespace kerf {

/// Throws Error naming the first value out of range.
void CheckParams(const CoupledParams& params);

/// Returns the pose. Throws Error if it is not valid or not within the world.
Pose MakeStart(const Pose& X_WT);

/// Returns the number of leaves whose old values are kept to compute the removed volume: all leaves of the bone's
/// initial surface, but at most as many as the spare leaves, or 4096 if there are fewer of these.
int CountOldLeaves(const BoneField& field, const CoupledParams& params);

}  // namespace kerf
