// Kinematics of the Falcon's three legs: converts between the angles of the motor arms and the grip position, and
// between forces and torques.
//
// Positions are in frame D (devices/driver.h). libnifalcon's frame has the same orientation: its z increases as the
// grip is pulled out, towards the user, and programs that use it take its x as right and its y as up (H3D's HAPI,
// NiFalconHapticsDevice). Its origin is 125 mm behind that of frame D. The leg dimensions are from libnifalcon,
// include/falcon/core/FalconGeometry.h (revision f7c727a). The equations are derived from the corresponding drawing (R.
// E. Stamper, thesis PhD 97-4, University of Maryland). None of this has been checked against a real device. All
// functions are tick-safe.
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

/// Position of the origin of frame D in libnifalcon's frame, along z.
inline constexpr double kFalconMiddle_mm = 125;
inline constexpr double kFalconRadPerCount = 14.25 / 110 / (4 * 320) * 6.283185307179586;  // 0.03643 degrees
inline constexpr double kFalconAngleOfZero_rad = 35 * 6.283185307179586 / 360;             // arm angle at count 0

/// Returns the arm angles at these encoder counts.
FalconAngles CalcFalconAngles(const FalconCounts& counts) noexcept;
/// Returns the encoder counts nearest to these arm angles.
FalconCounts CalcFalconCounts(const FalconAngles& angles) noexcept;

/// Returns the arm angles for a grip position (inverse kinematics in closed form), or nullopt if a leg cannot reach it.
std::optional<FalconAngles> CalcFalconAnglesAt(const Vec3& p_D_mm) noexcept;

/// Returns the derivative of the angles with respect to the position, rad/mm: theta_dot = J v, with row i for leg i.
/// Returns nullopt if a leg cannot reach the position or is at a dead point.
std::optional<glm::dmat3> CalcFalconJacobian(const Vec3& p_D_mm) noexcept;

/// Returns the torques of the motor arms for a force f_D at the grip, N mm, in the direction of the angles: tau =
/// inverse of J^T, times f. Returns nullopt if there is no Jacobian or it is singular.
std::optional<Vec3> CalcFalconTorques(const Vec3& p_D_mm, const Vec3& f_D_N) noexcept;
/// Returns the force at the grip for the given torques, N: f = J^T tau.
std::optional<Vec3> CalcFalconForce(const Vec3& p_D_mm, const Vec3& tau_Nmm) noexcept;

/// Forward kinematics by Newton's method. It starts from the last grip position, or from the position in which all legs
/// have the mean angle.
class FalconForward {
 public:
  /// Returns false and keeps the last position if no position is found for these angles.
  bool Solve(const FalconAngles& angles) noexcept;
  Vec3 p_D_mm() const { return p_D_mm_; }
  void Forget() { p_D_mm_ = Vec3{0}; }
  int steps() const { return steps_; }  // number of Newton steps in the last call

 private:
  Vec3 p_D_mm_{0};
  int steps_ = 0;
};

}  // namespace kerf
