// Kinematics of the Falcon's three legs: angles of the motor arms to grip position and back, forces to torques.
//
// Frame D (devices/driver.h). libnifalcon's frame has the same orientation: its z increases as the grip is pulled out,
// towards the user, and programs that use it take its x as right and its y as up (H3D's HAPI, NiFalconHapticsDevice).
// Its origin is 125 mm behind that of frame D. Leg dimensions: libnifalcon, include/falcon/core/FalconGeometry.h
// (revision f7c727a). The equations are derived from the corresponding drawing (R. E. Stamper, thesis PhD 97-4,
// University of Maryland). Not checked against a real device. All functions are tick-safe.
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Angles of the three arms, rad. They increase as the grip moves out.
using FalconAngles = std::array<double, 3>;
/// Counts of the three encoders after homing.
using FalconCounts = std::array<int, 3>;

/// Origin of frame D in libnifalcon's frame, along z.
inline constexpr double kFalconMiddle_mm = 125;
inline constexpr double kFalconRadPerCount = 14.25 / 110 / (4 * 320) * 6.283185307179586;  // 0.03643 degrees
inline constexpr double kFalconAngleOfZero_rad = 35 * 6.283185307179586 / 360;

/// Returns the arm angles at these encoder counts.
FalconAngles CalcFalconAngles(const FalconCounts& counts) noexcept;
/// Returns the nearest counts.
FalconCounts CalcFalconCounts(const FalconAngles& angles) noexcept;

/// Inverse kinematics in closed form. Returns nullopt if a leg cannot reach the position.
std::optional<FalconAngles> CalcFalconAnglesAt(const Vec3& p_D_mm) noexcept;

/// Returns the derivative of the angles with respect to the position, rad/mm: theta_dot = J v, row i for leg i. Returns
/// nullopt if a leg cannot reach the position or is at a dead point.
std::optional<glm::dmat3> CalcFalconJacobian(const Vec3& p_D_mm) noexcept;

/// Returns the torques of the motor arms for a force f_D at the grip, N mm, in the direction of the angles: tau = J^-T
/// f. Returns nullopt if there is no Jacobian or it is singular.
std::optional<Vec3> CalcFalconTorques(const Vec3& p_D_mm, const Vec3& f_D_N) noexcept;
/// Returns the force at the grip for given torques, N: f = J^T tau.
std::optional<Vec3> CalcFalconForce(const Vec3& p_D_mm, const Vec3& tau_Nmm) noexcept;

/// Forward kinematics by Newton's method. Starts from the last grip position, or from the position in which all legs
/// have the mean angle.
class FalconForward {
 public:
  /// Returns false and keeps the last position if none is found for these angles.
  bool Solve(const FalconAngles& angles) noexcept;
  Vec3 p_D_mm() const { return p_D_mm_; }
  void Forget() { p_D_mm_ = Vec3{0}; }
  int steps() const { return steps_; }  // Newton steps of the last call

 private:
  Vec3 p_D_mm_{0};
  int steps_ = 0;
};

}  // namespace kerf
