// Somebody who looks at a loop that runs without the clock, tick by tick.
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

  /// Between two ticks, outside the heap guard. `wall_us`: that the tick took, with the simulated hand and device and
  /// what it tells others.
  virtual void Take(double wall_us, const LoopSample& sample, CoupledSimulation& simulation) = 0;
};

}  // namespace kerf
