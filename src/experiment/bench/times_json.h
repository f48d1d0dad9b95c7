// Measured figures as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "base/core/percentiles.h"
#include "experiment/bench/measure.h"

namespace kerf {

/// Rounds to six significant digits, which exceeds the accuracy of any measurement. Returns null if the value is not
/// finite.
nlohmann::ordered_json RoundedJson(double value);
/// Returns the number of ticks, and the percentiles in us.
nlohmann::ordered_json TimesJson(const Percentiles& times);

}  // namespace kerf
