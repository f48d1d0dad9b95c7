// Where the handle of a WoodenHaptics-type device is, and what its motors do there. Frame D (devices/driver.h).
// Tick-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "device/devices/hid/wooden_params.h"

namespace kerf {

using WoodenCounts = std::array<std::int16_t, 3>;

/// Angles of the joints a, b, c, rad.
Vec3 CalcWoodenAngles(const WoodenParams& params, const WoodenCounts& counts);
/// The counts that come nearest; held to 16 bits.
WoodenCounts CalcWoodenCounts(const WoodenParams& params, const Vec3& angles);

Vec3 CalcWoodenPosition(const WoodenParams& params, const Vec3& angles);
/// dp_D/dangle, one column for each joint, mm/rad.
std::array<Vec3, 3> CalcWoodenJacobian(const WoodenParams& params, const Vec3& angles);
/// The angles that bring the handle there, with the elbow above the line from joint b to the handle. None where it
/// can't reach.
std::optional<Vec3> FindWoodenAngles(const WoodenParams& params, const Vec3& p_D_mm);

/// Currents of the motors for a force on the hand, mA, each within the limit: where one would be beyond it, all are
/// made smaller by the same factor, which keeps the direction of the force. Zero for a force that is not finite.
Vec3 CalcWoodenCurrents(const WoodenParams& params, const Vec3& angles, const Vec3& f_D_N);
/// The force of currents (mA) on the hand, N. Zero where the arm is stretched out or folded: it makes no force there
/// in some direction.
Vec3 CalcWoodenForce(const WoodenParams& params, const Vec3& angles, const Vec3& currents_mA);

}  // namespace kerf
