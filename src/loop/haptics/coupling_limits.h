// Limits on the stiffness and damping of the coupling that a device can render stably.
#pragma once

#include "device/devices/hand.h"
#include "kerf/coupled.h"
#include "kerf/device.h"

namespace kerf {

/// Stiffness and damping are in simulated newtons. The device renders them multiplied by `force_scale`.
struct CouplingLimits {
  double force_scale = 1;  // device N per simulated N
  double torque_scale = 0;
  double stiffness_N_per_mm = 0;  // maximum that the profile allows; infinite if the profile does not state one
  double damping_Ns_per_mm = 0;
  double torsion_Nmm_per_rad = 0;
  double torsion_damping_Nmms = 0;
  /// The coupling is stable with this hand on the device while K < 2 b / (T + 2 t_d), where b is the damping of the
  /// device and the hand, and t_d the delay in addition to the tick's own (Gil, Hulin et al.). Their rule adds the
  /// coupling's own damping to b. It is omitted here, because it acts on a delayed velocity.
  double sampled_stiffness_N_per_mm = 0;
  /// The same limit for rotation, with the hand's rotational damping. Infinite for a device without torque output, and
  /// for a hand whose rotational stiffness and damping are unknown.
  double sampled_torsion_Nmm_per_rad = 0;
  /// Maximum damping that is stable with a delayed velocity at the coupling's stiffness: 0.8 m / (t (1 + 2 (K + k) t^2
  /// / m)), where m is the mass of the device and the hand, k the stiffness of the hand, and t the delay of the
  /// damper's force. The formula is a fit to the closed loop of a mass. With this damping, the loop tolerates twice the
  /// gain and one additional tick of delay if the stiffness is at most kSampledFraction of that given by the rule
  /// above.
  double sampled_damping_Ns_per_mm = 0;
  /// The encoder's quantisation causes no limit cycle while K <= 2 f_c / Delta, where f_c is the device's friction and
  /// Delta its resolution (Abbott and Okamura 2005). 0 for a device without friction: it cannot meet this limit, and
  /// only damping acts against the limit cycle.
  double quantum_stiffness_N_per_mm = 0;
  /// Force of one encoder step at the coupling's stiffness, for comparison with the noise of the force.
  double step_N = 0;
};

/// Computes the limits for a tick of `dt_s`. `delay_ticks`: delay in addition to that tick, in ticks.
CouplingLimits CalcCouplingLimits(const DeviceProfile& profile, const HandModel& hand, const CouplingParams& coupling,
                                  double force_scale, double torque_scale, double dt_s, int delay_ticks = 0);

/// Maximum fraction of sampled_stiffness_N_per_mm and sampled_torsion_Nmm_per_rad that a coupling may use. The rule
/// assumes a linear spring and a known hand; neither assumption is exact. With this value, the loop tolerates 1 / 0.3 =
/// 3.3 times the gain. It tolerates one additional tick of delay for fractions up to 1/3, so this value leaves a margin
/// of a tenth. At 0.5, it would not tolerate the additional tick. Measured with every profile and hand:
/// docs/stability.md.
constexpr double kSampledFraction = 0.3;

/// A force that is held over a tick is on average half a tick old, so a spring returns up to 1/2 K dx^2 more energy per
/// tick than it stored. A damper of K T / 2 dissipates that energy. The damper's velocity is also half a tick old, so a
/// coupling has at least this multiple of K T / 2, within the limits of the device and the loop (docs/decisions.md).
constexpr double kHoldingFraction = 1.5;

/// Maximum damping of a coupling (CouplingParams); FitCoupling() does not raise it further.
constexpr double kMaxCouplingDamping_Ns_per_mm = 1;

/// Reasons why a coupling was reduced.
struct CouplingLowered {
  bool by_device = false;        // stiffness or damping was above the profile's limit
  bool by_loop = false;          // stiffness was above kSampledFraction of the limit of a sampled loop with this hand
  bool torsion_by_loop = false;  // the same for torsion
  bool damping_by_loop = false;  // damping was above the limit for a delayed velocity
  bool any() const { return by_device || by_loop || torsion_by_loop || damping_by_loop; }
};

/// A coupling, reduced to the limits of the device and the loop. The loop's limit omits the coupling's own damping,
/// which acts on a delayed velocity. The damping is then raised to kHoldingFraction times K T / 2, within the same
/// limits. `limits` are those of the resulting coupling. `dt_s` and `delay_ticks` are as in CalcCouplingLimits().
struct FittedCoupling {
  CouplingParams coupling;
  CouplingLimits limits;
  CouplingLowered lowered;
};
FittedCoupling FitCoupling(const DeviceProfile& profile, const HandModel& hand, const CouplingParams& coupling,
                           double force_scale, double torque_scale, double dt_s, int delay_ticks = 0);

/// Returns the coupling with stiffness and damping reduced to the profile's limits. Sets `changed` (optional) to true
/// if any value was reduced.
CouplingParams LimitCoupling(CouplingParams coupling, const CouplingLimits& limits, bool* changed = nullptr);

}  // namespace kerf
