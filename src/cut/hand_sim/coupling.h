// Coupling between handle and tool: springs and dampers with limited force.
#pragma once

#include "cut/contact/motion.h"
#include "cut/contact/step.h"
#include "kerf/coupled.h"
#include "kerf/geometry.h"

namespace kerf {

/// Spring and damper between handle and tool, which act at the coupling point C of the tool.
class Coupling {
 public:
  /// `side_N_per_mm`: stiffness of the tool against bending sideways (CalcSideStiffness()); 0: it is rigid.
  Coupling(const CouplingParams& params, double side_N_per_mm);

  const Vec3& p_TC_mm() const { return p_TC_; }
  /// Returns the coupling for a step from X_WT. Tick-safe.
  StepCoupling MakeStep(const Pose& X_WT, const CoupledInput& in) const;
  /// Returns the energy of the springs, N mm. Tick-safe.
  double CalcEnergy(const Pose& X_WT, const Pose& X_WH) const;
  struct Load {
    Vec3 f_W_N{0};
    Vec3 tau_W_Nmm{0};  // about the coupling point
    bool limited = false;
  };
  /// Returns the load of the springs on the hand. Tick-safe.
  Load CalcLoadOnHand(const Pose& X_WT, const Pose& X_WH) const;

 private:
  Bending CalcBending(const Vec3& across) const { return {across, bending_factor_}; }

  Vec3 p_TC_;
  double bending_factor_;
  SaturatingSpring spring_, torsion_, damper_, torsion_damper_;
};

}  // namespace kerf
