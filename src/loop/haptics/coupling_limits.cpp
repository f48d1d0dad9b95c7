#include "loop/haptics/coupling_limits.h"

#include <algorithm>
#include <limits>

namespace kerf {
namespace {

/// Delay of the coupling's damper force, ticks: half the length of the velocity estimator's longest window (16 samples,
/// AdaptiveVelocity) with an encoder, or of a window of two samples without one, plus half a tick, which is the average
/// age of a held force.
constexpr double kEncoderDelay_ticks = 8;
constexpr double kNoEncoderDelay_ticks = 1;
/// Factor in the formula of `sampled_damping_Ns_per_mm` (coupling_limits.h). With this value, the loop tolerates twice
/// the gain. The margin covers the compliance of bone and teeth.
constexpr double kDampingFactor = 0.8;

}  // namespace

CouplingLimits CalcCouplingLimits(const DeviceProfile& profile, const HandModel& hand, const CouplingParams& coupling,
                                  double force_scale, double torque_scale, double dt_s, int delay_ticks) {
  const auto of_sim = [](double device, double scale) {
    return device > 0 && scale > 0 ? device / scale : std::numeric_limits<double>::infinity();
  };
  CouplingLimits limits;
  limits.force_scale = force_scale;
  limits.torque_scale = torque_scale;
  limits.stiffness_N_per_mm = of_sim(profile.max_stiffness_N_per_mm, force_scale);
  limits.damping_Ns_per_mm = of_sim(profile.max_damping_Ns_per_mm, force_scale);
  limits.torsion_Nmm_per_rad = of_sim(profile.max_torsion_Nmm_per_rad, torque_scale);
  limits.torsion_damping_Nmms = of_sim(profile.max_torsion_damping_Nmms, torque_scale);
  const double b = profile.own_damping_Ns_per_mm + hand.damping_Ns_per_mm;
  limits.sampled_stiffness_N_per_mm = 2 * b / (dt_s * (1 + 2 * delay_ticks)) / force_scale;
  const double delay_s =
      dt_s * ((profile.resolution_mm > 0 ? kEncoderDelay_ticks : kNoEncoderDelay_ticks) + delay_ticks);
  const double m = 1e-3 * (profile.mass_kg + hand.mass_kg);
  const double held_N_per_mm = force_scale * coupling.stiffness_N_per_mm + hand.stiffness_N_per_mm;
  limits.sampled_damping_Ns_per_mm =
      of_sim(kDampingFactor * m / (delay_s * (1 + 2 * held_N_per_mm * delay_s * delay_s / m)), force_scale);
  const double c = hand.torsion_damping_Nmms;
  limits.sampled_torsion_Nmm_per_rad = hand.torsion_Nmm_per_rad > 0
                                           ? of_sim(2 * c / (dt_s * (1 + 2 * delay_ticks)), torque_scale)
                                           : std::numeric_limits<double>::infinity();
  limits.quantum_stiffness_N_per_mm = profile.resolution_mm > 0
                                          ? 2 * profile.friction_N / profile.resolution_mm / force_scale
                                          : std::numeric_limits<double>::infinity();
  limits.step_N = coupling.stiffness_N_per_mm * profile.resolution_mm;
  return limits;
}

CouplingParams LimitCoupling(CouplingParams coupling, const CouplingLimits& limits, bool* changed) {
  bool any = false;
  const auto lower = [&any](double& value, double limit) {
    if (value <= limit) return;
    value = limit;
    any = true;
  };
  lower(coupling.stiffness_N_per_mm, limits.stiffness_N_per_mm);
  lower(coupling.damping_Ns_per_mm, limits.damping_Ns_per_mm);
  lower(coupling.torsion_Nmm_per_rad, limits.torsion_Nmm_per_rad);
  lower(coupling.torsion_damping_Nmms, limits.torsion_damping_Nmms);
  if (changed != nullptr) *changed = any;
  return coupling;
}

FittedCoupling FitCoupling(const DeviceProfile& profile, const HandModel& hand, const CouplingParams& coupling,
                           double force_scale, double torque_scale, double dt_s, int delay_ticks) {
  const auto calc = [&](const CouplingParams& of) {
    return CalcCouplingLimits(profile, hand, of, force_scale, torque_scale, dt_s, delay_ticks);
  };
  FittedCoupling fitted;
  fitted.coupling = LimitCoupling(coupling, calc(coupling), &fitted.lowered.by_device);
  const CouplingLimits sure = calc(fitted.coupling);
  const double held = kSampledFraction * sure.sampled_stiffness_N_per_mm;
  if (fitted.coupling.stiffness_N_per_mm > held) {
    fitted.coupling.stiffness_N_per_mm = held;
    fitted.lowered.by_loop = true;
  }
  const double held_torsion = kSampledFraction * sure.sampled_torsion_Nmm_per_rad;
  if (fitted.coupling.torsion_Nmm_per_rad > held_torsion) {
    fitted.coupling.torsion_Nmm_per_rad = held_torsion;
    fitted.lowered.torsion_by_loop = true;
  }
  fitted.limits = calc(fitted.coupling);
  const double max_Ns_per_mm = fitted.limits.sampled_damping_Ns_per_mm;
  if (fitted.coupling.damping_Ns_per_mm > max_Ns_per_mm) {
    fitted.coupling.damping_Ns_per_mm = max_Ns_per_mm;
    fitted.lowered.damping_by_loop = true;
  }
  const double holding_Ns_per_mm = kHoldingFraction * 0.5 * dt_s * fitted.coupling.stiffness_N_per_mm;
  fitted.coupling.damping_Ns_per_mm = std::max(
      fitted.coupling.damping_Ns_per_mm,
      std::min({holding_Ns_per_mm, fitted.limits.damping_Ns_per_mm, max_Ns_per_mm, kMaxCouplingDamping_Ns_per_mm}));
  return fitted;
}

}  // namespace kerf
