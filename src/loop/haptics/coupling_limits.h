// How stiff a coupling a device bears.
#pragma once

#include "device/devices/device.h"
#include "device/devices/hand.h"
#include "kerf/coupled.h"

namespace kerf {

/// All stiffness and damping in the simulation's newtons: the device feels them times force_scale.
struct CouplingLimits {
  double force_scale = 1;  // device N per simulation N
  double torque_scale = 0;
  double stiffness_N_per_mm = 0;  // most that the profile allows; infinite when it says nothing
  double damping_Ns_per_mm = 0;
  double torsion_Nmm_per_rad = 0;
  double torsion_damping_Nmms = 0;
  /// Stable with this hand on the device while K < 2 b / (T + 2 t_d): b of device and hand, t_d delay besides the
  /// tick's own (Gil, Hulin et al.). The coupling's own damping, which their rule adds to b, is left out: it goes by a
  /// velocity that comes late.
  double sampled_stiffness_N_per_mm = 0;
  /// The same of turning, by the hand's damping against it. Infinite for a device that drives no torques, and with a
  /// hand of whose turning nothing is known.
  double sampled_torsion_Nmm_per_rad = 0;
  /// Most damping that a velocity which comes so late bears at the coupling's stiffness: 0.8 m / (t (1 + 2 (K + k) t^2
  /// / m)), m of device and hand, k of the hand, t how late the force of the damper is. A fit to the closed loop of a
  /// mass, by which twice the gain and a tick of delay are borne where the stiffness is at most kSampledShare of the
  /// rule's.
  double sampled_damping_Ns_per_mm = 0;
  /// No limit cycle from the encoder's steps while K <= 2 f_c / Delta: f_c friction of the device (Abbott and Okamura
  /// 2005). 0 without friction: there is no such limit to keep, damping alone must do.
  double quantum_stiffness_N_per_mm = 0;
  double step_N =
      0;  // force of one step of the encoder, at the coupling's stiffness: what noise has to be held against
};

/// Tick dt_s, delay in ticks beyond it.
CouplingLimits CalcCouplingLimits(const DeviceProfile& profile, const HandModel& hand, const CouplingParams& coupling,
                                  double force_scale, double torque_scale, double dt_s, int delay_ticks = 0);

/// Share of sampled_stiffness_N_per_mm, and of sampled_torsion_Nmm_per_rad, that a coupling is given at most: the rule
/// is for a linear spring and a hand that is known, and neither is. With it the loop bears a gain 1 / 0.3 = 3.3 times
/// as high, and a further tick of delay, up to 1/3 of the rule, with a tenth to spare. At 0.5 it would not bear the
/// tick. Measured with every profile and hand: docs/stability.md.
constexpr double kSampledShare = 0.3;

/// A force that is held over a tick is half a tick old in the mean, so that a spring gives back up to 1/2 K dx^2 a tick
/// more than it took. A damper of K T / 2 takes that back. It knows the velocity half a tick late itself, so a coupling
/// has so many times that at least, as far as device and loop bear it (docs/decisions.md).
constexpr double kHoldingShare = 1.5;

/// The greatest damping that a coupling may have (CouplingParams): it is raised no further.
constexpr double kMostCouplingDamping_Ns_per_mm = 1;

/// By what a coupling was lowered.
struct CouplingLowered {
  bool by_device = false;        // a stiffness or damping above what its profile allows
  bool by_loop = false;          // the stiffness above kSampledShare of what a sampled loop with this hand holds
  bool torsion_by_loop = false;  // likewise against turning
  bool damping_by_loop = false;  // the damping above what a late velocity bears
  bool any() const { return by_device || by_loop || torsion_by_loop || damping_by_loop; }
};

/// The coupling lowered to what device and loop bear, the loop without the coupling's own damping, which goes by a
/// velocity that comes late; its damping then raised to kHoldingShare, as far as device and loop bear it. `limits` are
/// those of the result. Tick dt_s, delay as above.
struct FittedCoupling {
  CouplingParams coupling;
  CouplingLimits limits;
  CouplingLowered lowered;
};
FittedCoupling FitCoupling(const DeviceProfile& profile, const HandModel& hand, const CouplingParams& coupling,
                           double force_scale, double torque_scale, double dt_s, int delay_ticks = 0);

/// The coupling with its stiffness and damping lowered to what the profile allows, where they are above. `changed` (may
/// be null) tells whether any was.
CouplingParams LimitCoupling(CouplingParams coupling, const CouplingLimits& limits, bool* changed = nullptr);

}  // namespace kerf
