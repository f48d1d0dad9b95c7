// Ends a live loop in a test after a given duration of motion.
#pragma once

#include <atomic>
#include <span>

#include "session/run/run_loop.h"

namespace kerf::test {

/// Ends a live loop once its hand has moved for `motion_s`. If the machine stalls, the hand falls behind the clock by
/// each gap minus kMaxTickDt_s. Must outlive the loop.
class EndsAfterMotion {
 public:
  EndsAfterMotion(double motion_s, LoopOptions& options) : left_s_(motion_s) {
    options.seconds = 300;
    options.stop = &ended_;
    options.watchers.take_tick = [this](const LoopTick& sample, std::span<const double> /*channels*/) {
      left_s_ -= sample.in.dt_s;
      if (left_s_ <= 0) ended_ = true;
    };
  }
  EndsAfterMotion(const EndsAfterMotion&) = delete;
  EndsAfterMotion& operator=(const EndsAfterMotion&) = delete;

 private:
  double left_s_;
  std::atomic<bool> ended_{false};
};

}  // namespace kerf::test
