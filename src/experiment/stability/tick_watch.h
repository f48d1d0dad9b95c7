// Conditions that must hold in every tick of every scenario.
#pragma once

#include "experiment/stability/closed_loop.h"

namespace kerf {

/// Receives a loop's ticks one by one and keeps the worst violation of each condition.
class TickWatch {
 public:
  void Add(const ClosedLoopTick& tick);

  int not_finite() const { return not_finite_; }  // ticks with a value that is not finite
  double largest_N() const { return largest_N_; }
  /// Returns the largest change between ticks; a step to zero, as after a fault, does not count.
  double largest_step_N() const { return largest_step_N_; }
  double largest_torque_Nmm() const { return largest_torque_Nmm_; }
  /// Returns the largest simulated force while nothing is near the tool. It must be 0: the tool then coincides with the
  /// handle, so that, whatever the gains, no spring is stretched and no damper has a relative velocity.
  double largest_in_air_N() const { return largest_in_air_N_; }

 private:
  Vec3 before_N_{0};
  int not_finite_ = 0;
  double largest_N_ = 0;
  double largest_step_N_ = 0;
  double largest_torque_Nmm_ = 0;
  double largest_in_air_N_ = 0;
};

}  // namespace kerf
