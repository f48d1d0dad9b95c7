#include "cut/hand_sim/coupling.h"

#include <cmath>

namespace kerf {
namespace {

const Vec3 kAcross(0, 0, 1);  // across a blade, in the frames of tool and handle

}  // namespace

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

Coupling::Coupling(const CouplingParams& params, double side_N_per_mm)
    : p_TC_(params.p_TC_mm),
      bending_factor_(params.blade_bends && side_N_per_mm > 0
                          ? std::sqrt(side_N_per_mm / (params.stiffness_N_per_mm + side_N_per_mm))
                          : 1),
      spring_{params.stiffness_N_per_mm, params.max_force_N},
      torsion_{params.torsion_Nmm_per_rad, params.max_torque_Nmm},
      damper_{params.damping_Ns_per_mm, params.max_force_N},
      torsion_damper_{params.torsion_damping_Nmms, params.max_torque_Nmm} {}

StepCoupling Coupling::MakeStep(const Pose& X_WT, const CoupledInput& in) const {
  StepCoupling step;
  step.spring = spring_;
  step.torsion = torsion_;
  step.damper = damper_;
  step.torsion_damper = torsion_damper_;
  step.bending = CalcBending(X_WT.InverseVector(in.X_WH.Vector(kAcross)));
  step.x_mm = X_WT.InverseVector(in.X_WH.Point(p_TC_) - X_WT.Point(p_TC_));
  step.theta_rad = LogRotation(glm::conjugate(X_WT.R_AB) * in.X_WH.R_AB);
  step.v_H_mm_per_s = X_WT.InverseVector(in.v_H_W_mm_per_s);
  step.w_H_rad_per_s = X_WT.InverseVector(in.w_H_W_rad_per_s);
  return step;
}

double Coupling::CalcEnergy(const Pose& X_WT, const Pose& X_WH) const {
  const Bending bending = CalcBending(X_WH.Vector(kAcross));
  return spring_.Energy(bending.Scale(X_WH.Point(p_TC_) - X_WT.Point(p_TC_))) +
         torsion_.Energy(LogRotation(glm::conjugate(X_WT.R_AB) * X_WH.R_AB));
}

Coupling::Load Coupling::CalcLoadOnHand(const Pose& X_WT, const Pose& X_WH) const {
  const Bending bending = CalcBending(X_WH.Vector(kAcross));
  const Vec3 x = bending.Scale(X_WT.Point(p_TC_) - X_WH.Point(p_TC_));
  const Vec3 theta = X_WT.Vector(LogRotation(glm::conjugate(X_WT.R_AB) * X_WH.R_AB));
  return {bending.Scale(spring_.Force(x)), torsion_.Force(-theta),
          spring_.IsSaturated(x) || torsion_.IsSaturated(theta)};
}

}  // namespace kerf
