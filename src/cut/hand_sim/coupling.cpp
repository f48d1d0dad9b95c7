#include "cut/hand_sim/coupling.h"

#include <cmath>

namespace kerf {
namespace {

const Vec3 kAcross(0, 0, 1);  // across a blade, in the frames of tool and handle

}  // namespace

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
