// Durations of the stages of a tick and of the effects, compared with the time available.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "loop/haptics/stage_timer.h"

namespace kerf {

/// A stage of the tick, or an effect. An effect's time is included in the stages' times.
struct PartCost {
  std::string name;
  std::uint64_t ticks = 0;  // number of ticks in which it ran
  double mean_us = 0;       // over all ticks: the stages' means add up to the tick's, except for reading the clock
  double p50_us = 0;        // over the ticks in which it ran; likewise the following
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};

struct StageCosts {
  double budget_us = 0;    // period of the ticks
  std::uint64_t over = 0;  // number of ticks that took longer
  PartCost tick;
  std::vector<PartCost> stages;
  std::vector<PartCost> effects;
};

/// Options for timing the stages. `live` is called several times a second with a readable line.
struct CostOptions {
  bool costs = false;
  std::function<void(const std::string& line)> live;
};

/// May be called during or after the ticks, in any thread.
StageCosts MakeStageCosts(const LogHistogram& ticks, const StageTimer& stages, const EffectPlan& plan,
                          double budget_us);

/// Returns one line for a terminal.
std::string FormatCostLine(const StageCosts& costs);
/// Returns a table, with its lines indented by two spaces.
std::string FormatCostTable(const StageCosts& costs);

/// Times the ticks of a run along a path.
class StageCostMeter {
 public:
  explicit StageCostMeter(double budget_us) : budget_us_(budget_us), stages_(clock_) {}

  void Watch(EffectPlan& plan) { stages_.Watch(plan); }
  TickObserver& observer() { return stages_; }
  void Finish(double tick_us) {
    stages_.Finish();
    ticks_.Add(static_cast<std::int64_t>(1000 * tick_us));
  }
  StageCosts Make(const EffectPlan& plan) const { return MakeStageCosts(ticks_, stages_, plan, budget_us_); }

 private:
  double budget_us_;
  MonotonicClock clock_;
  StageTimer stages_;
  LogHistogram ticks_;
};

}  // namespace kerf
