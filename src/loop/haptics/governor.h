// Keeps the loop in time when ticks overrun persistently: steps the fidelity down, and up again once there is calm.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "kerf/coupled.h"

namespace kerf {

struct GovernorParams {
  bool degrade = false;        // false: nothing is ever stepped down
  double period_s = 0.001;     // of the loop
  double budget_share = 0.8;   // of the period, that a tick may take
  double overrun_share = 0.1;  // of the ticks in a window: more over budget, and it steps down
  double window_s = 0.1;       // over which ticks are counted
  double calm_share = 0.5;     // of the budget: a window is calm when no more than 1 % of its ticks take longer
  double calm_s = 2;           // of calm windows before a step up
  double longest_calm_s = 32;  // a step up that had to be taken back doubles the wait, up to this
};

enum class FidelityReason : std::uint8_t { kOverrun, kCalm };
const char* ToString(FidelityReason reason);

/// A step that was taken.
struct FidelityStep {
  double time_s = 0;
  Fidelity from = Fidelity::kFull;
  Fidelity to = Fidelity::kFull;
  FidelityReason reason = FidelityReason::kOverrun;
  double share_over = 0;  // of the window's ticks, over budget
  double longest_us = 0;  // tick in the window
};

/// Tick-safe; has no clock of its own.
class Governor {
 public:
  explicit Governor(const GovernorParams& params) : params_(params), wait_s_(params.calm_s) {}

  /// A tick that ended at `time_s` (not decreasing) took `tick_us`. The fidelity to change to, none when it stays.
  std::optional<Fidelity> Observe(double time_s, double tick_us);

  Fidelity fidelity() const { return fidelity_; }
  /// The first kKeptSteps of them; how many there were in all.
  std::span<const FidelityStep> steps() const {
    return {steps_.data(), static_cast<std::size_t>(step_count_ < kKeptSteps ? step_count_ : kKeptSteps)};
  }
  long step_count() const { return step_count_; }

  static constexpr long kKeptSteps = 64;

 private:
  void Step(double time_s, Fidelity to, FidelityReason reason);

  GovernorParams params_;
  Fidelity fidelity_ = Fidelity::kFull;
  // the window
  bool begun_ = false;
  double window_start_s_ = 0;
  long ticks_ = 0;
  long over_ = 0;
  long not_calm_ = 0;
  double longest_us_ = 0;
  // hysteresis
  double calm_since_s_ = 0;
  double wait_s_;
  double last_up_s_ = -1e300;
  std::array<FidelityStep, kKeptSteps> steps_{};
  long step_count_ = 0;
};

}  // namespace kerf
