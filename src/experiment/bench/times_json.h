// Measured figures as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "experiment/bench/measure.h"

namespace kerf {

/// Rounds to six digits, which is more than any measurement is accurate to; null if the value is not finite.
nlohmann::ordered_json RoundedJson(double value);
/// Number of ticks, and the percentiles in us.
nlohmann::ordered_json TimesJson(const Percentiles& times);

}  // namespace kerf
