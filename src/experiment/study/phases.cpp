#include "experiment/study/phases.h"

#include <cstddef>

#include "base/core/percentiles.h"
#include "experiment/study/errors.h"

namespace kerf {
namespace {

constexpr double kFull = 0.9;
constexpr double kGone = 0.1;

}  // namespace

std::vector<CutPhase> FindCutPhases(std::span<const ReferenceTick> ticks, double tick_s) {
  std::vector<double> engaged;
  for (const ReferenceTick& tick : ticks) {
    if (tick.engaged_teeth > 0) engaged.push_back(tick.engaged_teeth);
  }
  if (engaged.empty()) return {};
  const double most = CalcPercentile(engaged, 0.95);
  std::size_t first = ticks.size();             // the first tick with contact
  std::size_t full_from = ticks.size();         // the first tick with full engagement
  std::size_t full_to = 0, gone = 0, last = 0;  // one past the last tick with at least kFull * most, at least kGone *
                                                // most, and any teeth engaged
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    const double teeth = ticks[i].engaged_teeth;
    if (!(teeth > 0)) continue;
    if (first == ticks.size()) first = i;
    last = i + 1;
    if (teeth >= kGone * most) gone = i + 1;
    if (teeth < kFull * most) continue;
    if (full_from == ticks.size()) full_from = i;
    full_to = i + 1;
  }
  std::vector<CutPhase> phases;
  const auto add = [&](const char* name, std::size_t from, std::size_t to) {
    if (to > from) phases.push_back({name, tick_s * static_cast<double>(from), tick_s * static_cast<double>(to)});
  };
  add("entry", first, full_from);
  add("cut", full_from, full_to);
  add("breakthrough", full_to, gone);
  add("exit", gone, last);
  return phases;
}

}  // namespace kerf
