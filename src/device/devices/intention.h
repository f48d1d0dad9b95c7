// Where the hand wants the tool, as a function of time.
#pragma once

#include <vector>

#include "kerf/geometry.h"

namespace kerf {

struct Intention {
  Pose X_WH{};           // where the hand wants the tool frame
  Vec3 v_W_mm_per_s{0};  // how fast that moves
  Vec3 push_W_N{0};      // on the handle, besides the pull towards X_WH
  double yield_s = 0;    // above 0: along the push, X_WH gives way to where the handle is with this time constant,
                         // so that the push stays as it is while the tool goes ahead
};

/// One step of what the hand does. All of it changes smoothly: a stroke has minimum jerk (a fifth-order polynomial), a
/// push comes on over push_on_s, sawing swells and fades over a quarter of the step.
struct IntentionStep {
  double seconds = 1;      // 1e-3 to 1e6
  Pose X_WH{};             // at the end of the step; where the step before ended: a hold
  Vec3 push_W_N{0};        // from this step's beginning on; up to 1000
  double yield_s = 0;      // see Intention; 0 to 100
  Vec3 saw_W_mm{0};        // amplitude of a to and fro on top of the stroke; up to 100
  double saw_Hz = 0;       // 0 to 10: no hand wants to go faster
  double push_on_s = 0.3;  // 0 to 100
};

class IntentionScript {
 public:
  /// Throws Error naming the step and its first value out of range.
  IntentionScript(const Pose& X_WH_start, std::vector<IntentionStep> steps);

  double duration_s() const { return duration_s_; }
  /// Held to the ends before and after. Tick-safe; O(steps).
  Intention Calc(double t_s) const;

 private:
  Pose X_WH_start_;
  std::vector<IntentionStep> steps_;
  double duration_s_ = 0;
};

}  // namespace kerf
