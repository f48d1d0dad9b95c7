// Measured figures as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "experiment/bench/measure.h"

namespace kerf {

/// With six figures, which is more than any measurement is good for; null when it is not finite.
nlohmann::ordered_json RoundedJson(double value);
/// How many ticks, and the percentiles in us.
nlohmann::ordered_json TimesJson(const Percentiles& times);

}  // namespace kerf
