#include "experiment/bench/times_json.h"

#include <fmt/format.h>

#include <cmath>

namespace kerf {

nlohmann::ordered_json RoundedJson(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::stod(fmt::format("{:.6g}", value));
}

nlohmann::ordered_json TimesJson(const Percentiles& times) {
  return {{"ticks", times.count},
          {"p50_us", RoundedJson(times.p50_us)},
          {"p99_us", RoundedJson(times.p99_us)},
          {"p999_us", RoundedJson(times.p999_us)},
          {"max_us", RoundedJson(times.max_us)}};
}

}  // namespace kerf
