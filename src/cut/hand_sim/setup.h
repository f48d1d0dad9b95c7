// What is checked and worked out before the first tick.
#pragma once

#include "bone/grid/field.h"
#include "kerf/coupled.h"

namespace kerf {

/// Throws Error naming the first value out of range.
void CheckParams(const CoupledParams& params);

/// The pose itself. Throws Error when it is none, or out of the world.
Pose MakeStart(const Pose& X_WT);

/// Over how wide a range of speeds a law needs a ramp, mm/s: those that have a force at the least bite, others none.
double CalcRamp(const ToothForce& force, double creep_mm_per_s);

/// Leaves whose old values are kept for the account: all of the bone's first surface, but no more than are set aside
/// for the rest of it.
int CountOldLeaves(const BoneField& field, const CoupledParams& params);

}  // namespace kerf
