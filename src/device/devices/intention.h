// Intended motion of the hand as a function of time.
#pragma once

#include <vector>

#include <glm/geometric.hpp>
#include "kerf/describe.h"
#include "kerf/geometry.h"

namespace kerf {

struct Intention {
  Pose X_WH{};           // pose of the tool frame that the hand intends
  Vec3 v_W_mm_per_s{0};  // velocity of X_WH
  Vec3 push_W_N{0};      // force on the handle in addition to the pull towards X_WH
  double yield_s = 0;    // if above 0: along the push, X_WH follows the handle with this time constant, so that the
                         // push stays constant while the tool advances
};

/// A step of the hand's motion. All quantities change smoothly: a stroke has minimum jerk (a fifth-order polynomial), a
/// push rises over push_on_s, and a sawing motion grows during the first quarter of the step and fades during the last.
struct IntentionStep {
  double seconds = 1;
  Pose X_WH{};         // pose at the end of the step; the hand holds still if it equals that of the previous step
  Vec3 push_W_N{0};    // push from the start of this step on
  double yield_s = 0;  // see Intention
  Vec3 saw_W_mm{0};    // amplitude of an oscillation added to the stroke
  double saw_Hz = 0;
  double push_on_s = 0.3;
};
template <typename V>
void Describe(IntentionStep& p, V&& visit) {
  visit("seconds", p.seconds, Range{1e-3, 1e6}, "duration of the step");
  double push_N = glm::length(p.push_W_N);
  visit("push_N", push_N, Range{0, 1000}, "length of the push");
  visit("yield_s", p.yield_s, Range{0, 100}, "time constant with which the intention follows the handle");
  double saw_mm = glm::length(p.saw_W_mm);
  visit("saw_mm", saw_mm, Range{0, 100}, "amplitude of the oscillation");
  visit("saw_Hz", p.saw_Hz, Range{0, 10}, "its frequency; the limit is that of human motion");
  visit("push_on_s", p.push_on_s, Range{0, 100}, "time over which the push rises");
}

class IntentionScript {
 public:
  /// Throws a kerf::Error that names the step and its first value that is out of range.
  IntentionScript(const Pose& X_WH_start, std::vector<IntentionStep> steps);

  double duration_s() const { return duration_s_; }
  /// Computes the intention at the given time, which is clamped to the start and the end. Tick-safe; O(steps).
  Intention Calc(double t_s) const;

 private:
  Pose X_WH_start_;
  std::vector<IntentionStep> steps_;
  double duration_s_ = 0;
};

}  // namespace kerf
