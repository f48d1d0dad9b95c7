// Durations of the stages of a tick and of the effects, compared with the time available.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/core/percentiles.h"
#include "loop/haptics/stage_timer.h"

namespace kerf {

/// Durations of a tick, of one of its stages or of an effect. An effect's time is included in the stages' times.
struct PartTimes : Percentiles {
  std::string name;
  double mean_us = 0;  // in StageCosts over all ticks, so that the means add up, except for reading the clock
};

struct StageCosts {
  double budget_us = 0;    // period of the ticks
  std::uint64_t over = 0;  // number of ticks that took longer
  PartTimes tick;
  std::vector<PartTimes> stages;
  std::vector<PartTimes> effects;
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
