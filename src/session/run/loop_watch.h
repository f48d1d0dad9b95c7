// Observer of a loop that runs in virtual time, tick by tick.
#pragma once

#include "kerf/coupled.h"
#include "loop/haptics/haptic_loop.h"

namespace kerf {

class LoopWatch {
 public:
  LoopWatch() = default;
  LoopWatch(const LoopWatch&) = delete;
  LoopWatch& operator=(const LoopWatch&) = delete;
  virtual ~LoopWatch() = default;

  /// Called between two ticks, outside the heap guard. `wall_us`: duration of the tick, including the simulated hand
  /// and device and the exchange with other threads.
  virtual void Take(double wall_us, const LoopTick& sample, CoupledSimulation& simulation) = 0;
};

}  // namespace kerf
