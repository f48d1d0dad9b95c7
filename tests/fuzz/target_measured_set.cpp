#include <cmath>

#include "experiment/validation/measured_set.h"
#include "target.h"

namespace kerf::fuzz {

KERF_FUZZ_TARGET(measured_set) {
  MeasuredSet set;
  if (!Accepts([&] { set = ParseMeasuredSet(std::string(bytes), "fuzz.toml", "fuzz"); })) return;
  // Whatever an accepted set compares has numbers to compare with, and a tool that has the quantity.
  for (const MeasuredValue& value : set.values) {
    if (!IsGiven(value.value) && !(value.low <= value.high)) Finding("a value without numbers");
    if (FindQuantity(value.quantity).only_trend) Finding("a value of a quantity that is not simulated");
  }
  for (const MeasuredTrend& trend : set.trends) {
    MeasuredConditions at = JoinConditions(trend.at, set.conditions);
    if (IsGiven(trend.from) != IsGiven(trend.to)) Finding("a trend with one end");
    if (!IsGiven(trend.from) && trend.against != "density" && !IsGiven(ConditionOf(at, trend.against))) {
      Finding("a trend without its condition");
    }
  }
  if (!(set.values.empty() && set.trends.empty()) && set.tool.kind == kToolNone) Finding("nothing to simulate with");
}

}  // namespace kerf::fuzz
