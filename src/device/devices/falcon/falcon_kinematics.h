// The Falcon's three legs: angles of the motors' arms to the place of the grip and back, forces to torques.
//
// Frame D (devices/driver.h). libnifalcon's frame points the same way: its z grows as the grip is pulled out, towards
// the user, and programs that use it take its x as right and its y as up (H3D's HAPI, NiFalconHapticsDevice); its
// origin lies 125 mm behind ours. Lengths of the legs: libnifalcon, include/falcon/core/FalconGeometry.h (revision
// f7c727a); the equations are worked out anew from the drawing that they belong to (R. E. Stamper, thesis PhD 97-4,
// University of Maryland). Not checked against a real device. All functions are tick-safe.
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Of the three arms, rad. Larger: the grip is further out.
using FalconAngles = std::array<double, 3>;
/// Of the three encoders, once they are homed.
using FalconCounts = std::array<int, 3>;

/// Of the middle of frame D in libnifalcon's frame, along z.
inline constexpr double kFalconMiddle_mm = 125;
inline constexpr double kFalconRadPerCount = 14.25 / 110 / (4 * 320) * 6.283185307179586;  // 0.03643 degrees
inline constexpr double kFalconAngleOfZero_rad = 35 * 6.283185307179586 / 360;

/// Angles of encoders that stand at these counts.
FalconAngles CalcFalconAngles(const FalconCounts& counts) noexcept;
/// The nearest counts.
FalconCounts CalcFalconCounts(const FalconAngles& angles) noexcept;

/// Inverse kinematics, closed form. None where a leg can't reach.
std::optional<FalconAngles> CalcFalconAnglesAt(const Vec3& p_D_mm) noexcept;

/// How the angles change with the place, rad/mm: theta_dot = J v. Row i, leg i. None where a leg can't reach, or stands
/// at a dead point.
std::optional<glm::dmat3> CalcFalconJacobian(const Vec3& p_D_mm) noexcept;

/// Torques of the motors' arms that make force f_D at the grip there, N mm, in the angles' sense: tau = J^-T f. None
/// where there is no Jacobian or it can't be inverted.
std::optional<Vec3> CalcFalconTorques(const Vec3& p_D_mm, const Vec3& f_D_N) noexcept;
/// The force at the grip that torques make: f = J^T tau.
std::optional<Vec3> CalcFalconForce(const Vec3& p_D_mm, const Vec3& tau_Nmm) noexcept;

/// Forward kinematics by Newton's method from where the grip was last, or from where all legs stand as they do on
/// average.
class FalconForward {
 public:
  /// False: no place with these angles was found, and the last one is kept.
  bool Solve(const FalconAngles& angles) noexcept;
  Vec3 p_D_mm() const { return p_D_mm_; }
  void Forget() { p_D_mm_ = Vec3{0}; }
  int steps() const { return steps_; }  // of Newton's method, last

 private:
  Vec3 p_D_mm_{0};
  int steps_ = 0;
};

}  // namespace kerf
