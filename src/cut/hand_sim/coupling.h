// The tie between handle and tool: springs that hold with a greatest force, and dampers.
#pragma once

#include "cut/contact/step.h"
#include "kerf/coupled.h"
#include "kerf/geometry.h"

namespace kerf {

/// Unit quaternion of a rotation vector (rad), and back; the vector's length is at most pi. Tick-safe.
Quat ExpRotation(const Vec3& theta_rad);
Vec3 LogRotation(const Quat& R);

/// Where the tool is after moving for `time_s` with velocity and turning rate `u` (its own frame, about p_TC).
/// Tick-safe.
Pose Advance(const Pose& X_WT, const Twist& u, double time_s, const Vec3& p_TC_mm);

class Coupling {
 public:
  explicit Coupling(const CouplingParams& params);

  const Vec3& p_TC_mm() const { return p_TC_; }
  /// For a step from X_WT. Tick-safe.
  StepCoupling MakeStep(const Pose& X_WT, const CoupledInput& in) const;
  /// In the springs, N mm. Tick-safe.
  double CalcEnergy(const Pose& X_WT, const Pose& X_WH) const;
  struct Load {
    Vec3 f_W_N{0};
    Vec3 tau_W_Nmm{0};  // about the coupling point
    bool limited = false;
  };
  /// Of the springs on the hand. Tick-safe.
  Load CalcLoadOnHand(const Pose& X_WT, const Pose& X_WH) const;

 private:
  Vec3 p_TC_;
  SaturatingSpring spring_, torsion_, damper_, torsion_damper_;
};

}  // namespace kerf
