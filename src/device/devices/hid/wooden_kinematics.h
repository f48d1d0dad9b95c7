// Kinematics of WoodenHaptics-type devices: the position of the handle and the forces of the motors, in frame D
// (devices/driver.h). All functions are tick-safe.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "device/devices/hid/wooden_params.h"

namespace kerf {

using WoodenCounts = std::array<std::int16_t, 3>;

/// Returns the angles of the joints a, b, c, rad.
Vec3 CalcWoodenAngles(const WoodenParams& params, const WoodenCounts& counts);
/// Returns the encoder counts nearest to these angles, clamped to 16 bits.
WoodenCounts CalcWoodenCounts(const WoodenParams& params, const Vec3& angles);

/// Returns the position of the handle in frame D, mm.
Vec3 CalcWoodenPosition(const WoodenParams& params, const Vec3& angles);
/// Returns dp_D/dangle, one column for each joint, mm/rad.
std::array<Vec3, 3> CalcWoodenJacobian(const WoodenParams& params, const Vec3& angles);
/// Returns the angles for a handle position, with the elbow above the line from joint b to the handle; nullopt if the
/// position is out of reach.
std::optional<Vec3> FindWoodenAngles(const WoodenParams& params, const Vec3& p_D_mm);

/// Computes the motor currents for a force on the hand, mA. If one current would exceed its limit, all are reduced by
/// the same factor, which keeps the direction of the force. Returns zero for a force that is not finite.
Vec3 CalcWoodenCurrents(const WoodenParams& params, const Vec3& angles, const Vec3& f_D_N);
/// Computes the force on the hand, N, from the motor currents, mA. Returns zero if the arm is fully stretched or
/// folded, because it then cannot output force in some direction.
Vec3 CalcWoodenForce(const WoodenParams& params, const Vec3& angles, const Vec3& currents_mA);

}  // namespace kerf
