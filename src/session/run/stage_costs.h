// What each part of a tick costs, against the time that there is for it.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "loop/haptics/stage_timer.h"

namespace kerf {

/// A stage of the tick, or an effect; an effect's time is within the stages'.
struct PartCost {
  std::string name;
  std::uint64_t ticks = 0;  // that had it
  double mean_us = 0;       // over all ticks: the stages' add up to the tick's, but for the clock's own time
  double p50_us = 0;        // of the ticks that had it, as the others
  double p99_us = 0;
  double p999_us = 0;
  double max_us = 0;
};

struct StageCosts {
  double budget_us = 0;    // from tick to tick
  std::uint64_t over = 0;  // ticks that took longer than that
  PartCost tick;
  std::vector<PartCost> stages;
  std::vector<PartCost> effects;
};

/// Whether each part of a tick is timed, and who is told of it some times a second, in a line for people.
struct CostOptions {
  bool costs = false;
  std::function<void(const std::string& line)> live;
};

/// While ticks go on or after it; from any thread.
StageCosts MakeStageCosts(const LogHistogram& ticks, const StageTimer& stages, const EffectPlan& plan,
                          double budget_us);

/// For one line of a terminal.
std::string FormatCostLine(const StageCosts& costs);
/// A table, lines indented by two.
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
