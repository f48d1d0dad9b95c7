// What must hold of every tick, in whatever scenario.
#pragma once

#include "experiment/stability/closed_loop.h"

namespace kerf {

/// Takes a loop's ticks one by one and keeps the worst of what must not be.
class TickWatch {
 public:
  void Add(const ClosedLoopTick& tick);

  int not_finite() const { return not_finite_; }  // ticks with a value that is none
  double largest_N() const { return largest_N_; }
  double largest_step_N() const { return largest_step_N_; }  // from tick to tick; to zero, as after a fault, is none
  double largest_torque_Nmm() const { return largest_torque_Nmm_; }
  /// Force that the simulation gives while nothing is near the tool. It is then where the handle is: no spring is drawn
  /// and no damper has a part that moves against the other, whatever their gains.
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
