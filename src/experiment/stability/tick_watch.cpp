#include "experiment/stability/tick_watch.h"

#include <algorithm>

#include "base/core/vectors.h"

namespace kerf {
void TickWatch::Add(const ClosedLoopTick& tick) {
  const Vec3& f = tick.f_device_N;
  const CoupledOutput& out = tick.out.coupled;
  if (!IsFinite(f) || !IsFinite(out.f_H_W_N) || !IsFinite(out.X_WT.p_AB) || !IsFinite(tick.out.force.tau_H_W_Nmm) ||
      !IsFinite(tick.p_WC_mm)) {
    ++not_finite_;
  }
  largest_N_ = std::max(largest_N_, glm::length(f));
  if (f != Vec3(0)) largest_step_N_ = std::max(largest_step_N_, glm::length(f - before_N_));
  before_N_ = f;
  largest_torque_Nmm_ = std::max(largest_torque_Nmm_, glm::length(tick.out.force.tau_H_W_Nmm));
  if (tick.dt_s > 0 && (out.status & kCoupledAsleep) != 0) {
    largest_in_air_N_ = std::max(largest_in_air_N_, glm::length(out.f_H_W_N));
  }
}

}  // namespace kerf
