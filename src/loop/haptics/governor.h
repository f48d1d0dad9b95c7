// Lowers the fidelity when ticks persistently exceed their budget, and raises it again after a calm period.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "kerf/coupled.h"

namespace kerf {

struct GovernorParams {
  bool degrade = false;
  double period_s = 0.001;  // period of the loop
  double budget_share = 0.8;
  double overrun_share = 0.1;
  double window_s = 0.1;       // duration of a window in which ticks are counted
  double calm_fraction = 0.5;  // fraction of the budget: a window is calm if at most 1 % of its ticks take longer
  double calm_s = 2;
  double longest_calm_s = 32;  // each raise that has to be reverted doubles the required calm, up to this value
};

/// The keys that [loop] of a scene has too.
template <typename Params, typename V>
void DescribeGovernor(Params& p, V&& visit) {
  visit("degrade", p.degrade,
        "true: if ticks keep exceeding their time budget, the fidelity is lowered to coarse, then to slab");
  visit("budget_share", p.budget_share, Range{0.05, 1}, "fraction of the period that a tick may take: the time budget");
  visit("overrun_share", p.overrun_share, Range{0, 1},
        "fraction of the ticks in 0.1 s that may exceed the time budget before the fidelity is lowered");
  visit("calm_s", p.calm_s, Range{0.1, 3600},
        "time with ticks below half the budget after which the fidelity is raised again");
}

enum class FidelityReason : std::uint8_t { kOverrun, kCalm };
const char* ToString(FidelityReason reason);

/// A change of fidelity.
struct FidelityStep {
  double time_s = 0;
  Fidelity from = Fidelity::kFull;
  Fidelity to = Fidelity::kFull;
  FidelityReason reason = FidelityReason::kOverrun;
  double fraction_over = 0;  // fraction of the window's ticks over budget
  double longest_us = 0;     // longest tick of the window
};

/// Chooses the fidelity from the durations of ticks. Tick-safe; has no clock.
class Governor {
 public:
  explicit Governor(const GovernorParams& params) : params_(params), wait_s_(params.calm_s) {}

  /// Records a tick that ended at `time_s` (which must not decrease) and took `tick_us`. Returns the new fidelity, or
  /// none if it does not change.
  std::optional<Fidelity> Observe(double time_s, double tick_us);

  Fidelity fidelity() const { return fidelity_; }
  /// The first kKeptSteps changes; step_count() is the total number of changes.
  std::span<const FidelityStep> steps() const {
    return {steps_.data(), static_cast<std::size_t>(step_count_ < kKeptSteps ? step_count_ : kKeptSteps)};
  }
  long step_count() const { return step_count_; }

  static constexpr long kKeptSteps = 64;

 private:
  void Step(double time_s, Fidelity to, FidelityReason reason);

  GovernorParams params_;
  Fidelity fidelity_ = Fidelity::kFull;
  // The current window.
  bool begun_ = false;
  double window_start_s_ = 0;
  long ticks_ = 0;
  long over_ = 0;
  long not_calm_ = 0;
  double longest_us_ = 0;
  // Hysteresis.
  double calm_since_s_ = 0;
  double wait_s_;
  double last_up_s_ = -1e300;
  std::array<FidelityStep, kKeptSteps> steps_{};
  long step_count_ = 0;
};

}  // namespace kerf
