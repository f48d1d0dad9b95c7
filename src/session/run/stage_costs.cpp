#include "session/run/stage_costs.h"

#include <fmt/format.h>

#include <iterator>

#include "base/table/table.h"

namespace kerf {
namespace {

PartTimes Summarize(std::string name, const LogHistogram& times, std::uint64_t ticks) {
  PartTimes part{CalcPercentiles(times), std::move(name)};
  const double all = static_cast<double>(ticks);
  if (ticks > 0) part.mean_us = times.CalcMean_us() * static_cast<double>(part.count) / all;
  return part;
}

}  // namespace

StageCosts MakeStageCosts(const LogHistogram& ticks, const StageTimer& stages, const EffectPlan& plan,
                          double budget_us) {
  StageCosts costs;
  costs.budget_us = budget_us;
  costs.over = ticks.CountAbove_us(budget_us);
  const std::uint64_t count = ticks.total();
  costs.tick = Summarize("tick", ticks, count);
  for (std::size_t i = 0; i < kTickStages; ++i) {
    const auto stage = static_cast<TickStage>(i);
    if (stages.times(stage).total() == 0) continue;
    costs.stages.push_back(Summarize(ToString(stage), stages.times(stage), count));
  }
  for (std::size_t i = 0; i < stages.effect_count(); ++i) {
    costs.effects.push_back(Summarize(plan.entries()[i].info->name, stages.effect_times(i), count));
  }
  return costs;
}

std::string FormatCostLine(const StageCosts& c) {
  std::string line = fmt::format("tick {:.0f} us, p99 {:.0f} of {:.0f}:", c.tick.mean_us, c.tick.p99_us, c.budget_us);
  for (const PartTimes& part : c.stages) {
    if (part.mean_us >= 0.5) fmt::format_to(std::back_inserter(line), " {} {:.0f}", part.name, part.mean_us);
  }
  for (const PartTimes& part : c.effects) {
    if (part.mean_us >= 0.5) fmt::format_to(std::back_inserter(line), " [{} {:.0f}]", part.name, part.mean_us);
  }
  return line;
}

std::string FormatCostTable(const StageCosts& c) {
  TextTable table({"", "mean", "p50", "p99", "p99.9", "max", "p99 of budget"});
  const auto us = [](double time_us) { return fmt::format("{:.1f}", time_us); };
  const auto add = [&](const PartTimes& part, const std::string& name) {
    table.Add({name, fmt::format("{:.2f}", part.mean_us), us(part.p50_us), us(part.p99_us), us(part.p999_us),
               us(part.max_us), fmt::format("{:.1f} %", 100 * part.p99_us / c.budget_us)});
  };
  add(c.tick, c.tick.name);
  for (const PartTimes& part : c.stages) add(part, part.name);
  for (const PartTimes& part : c.effects) add(part, fmt::format("effect {}", part.name));
  return fmt::format("  cost      of {} ticks, {:.0f} us allowed each: {} took longer; us{}\n{}", c.tick.count,
                     c.budget_us, c.over, c.effects.empty() ? "" : "; effects are included in the stages",
                     table.FormatTerminal("            "));
}

}  // namespace kerf
