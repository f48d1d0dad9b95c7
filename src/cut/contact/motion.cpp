#include "cut/contact/motion.h"

#include <cmath>

namespace kerf {

Quat ExpRotation(const Vec3& theta_rad) {
  const double angle = glm::length(theta_rad);
  // sin(angle / 2) / angle; by its series for small angles, where the quotient loses digits.
  const double factor = angle < 1e-4 ? 0.5 - angle * angle / 48 : std::sin(0.5 * angle) / angle;
  return Quat(std::cos(0.5 * angle), factor * theta_rad.x, factor * theta_rad.y, factor * theta_rad.z);
}

Vec3 LogRotation(const Quat& R) {
  const double sign = R.w < 0 ? -1 : 1;
  const Vec3 v = sign * Vec3(R.x, R.y, R.z);
  const double sine = glm::length(v);
  if (sine == 0) return Vec3(0);
  const double angle = 2 * std::atan2(sine, sign * R.w);
  return (angle / sine) * v;
}

Pose WithUnitRotation(const Pose& X) {
  constexpr double kRounding = 1e-14;  // of the squared length, with room for some products of rotations
  if (std::abs(glm::dot(X.R_AB, X.R_AB) - 1) <= kRounding) return X;
  return {glm::normalize(X.R_AB), X.p_AB};
}

Pose Advance(const Pose& X_WT, const Twist& u, double time_s, const Vec3& p_TC_mm) {
  const Vec3 C_W = X_WT.Point(p_TC_mm) + X_WT.Vector(time_s * Vec3(u[0], u[1], u[2]));
  Pose X;
  X.R_AB = glm::normalize(X_WT.R_AB * ExpRotation(time_s * Vec3(u[3], u[4], u[5])));
  X.p_AB = C_W - X.Vector(p_TC_mm);
  return X;
}

Vec3 CalcAngularVelocity(const Quat& from, const Quat& to, double time_s) {
  constexpr double kRounding_rad = 1e-14;  // of two rotations of unit length, and of their interpolation
  const Vec3 theta_rad = LogRotation(glm::conjugate(from) * to);
  return glm::length(theta_rad) > kRounding_rad ? theta_rad / time_s : Vec3(0);
}

}  // namespace kerf
