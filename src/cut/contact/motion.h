// Motions of a tool between two poses.
#pragma once

#include "cut/contact/step.h"
#include "kerf/geometry.h"

namespace kerf {

/// Converts a rotation vector, rad, to a unit quaternion, and back to a vector with a length of at most pi. Tick-safe.
Quat ExpRotation(const Vec3& theta_rad);
Vec3 LogRotation(const Quat& R);

/// Returns the pose with its rotation scaled to length 1. A rotation that is 1 long to within rounding keeps its bits.
/// Tick-safe.
Pose WithUnitRotation(const Pose& X);

/// Returns the pose of the tool after it has moved for `time_s` with the twist `u`, which is expressed in the tool's
/// frame and about p_TC. Tick-safe.
Pose Advance(const Pose& X_WT, const Twist& u, double time_s, const Vec3& p_TC_mm);

/// Returns the constant angular velocity, rad/s, that leads from one rotation to another in `time_s` > 0 by the shorter
/// way, in the frame of the tool; exactly 0 if they differ by no more than rounding. Tick-safe.
Vec3 CalcAngularVelocity(const Quat& from, const Quat& to, double time_s);

}  // namespace kerf
