#include "base/table/table_json.h"

#include <fmt/format.h>

#include <cmath>

namespace kerf {
namespace {

using nlohmann::ordered_json;

}  // namespace

ordered_json NumberJson(double value) {
  return std::isfinite(value) ? ordered_json(value) : ordered_json();
}

ordered_json RoundedJson(double value, int digits) {
  return std::isfinite(value) ? ordered_json(std::stod(fmt::format("{:.{}g}", value, digits))) : ordered_json();
}

ordered_json TimesJson(const Percentiles& times) {
  return {{"ticks", times.count},
          {"p50_us", RoundedJson(times.p50_us)},
          {"p99_us", RoundedJson(times.p99_us)},
          {"p999_us", RoundedJson(times.p999_us)},
          {"max_us", RoundedJson(times.max_us)}};
}

ordered_json CellJson(const TableCell& cell, const std::string& format) {
  return std::visit(
      [&](const auto& value) {
        using T = std::decay_t<decltype(value)>;
        if constexpr (std::is_same_v<T, std::monostate>) {
          return ordered_json();
        } else if constexpr (std::is_same_v<T, double>) {
          if (format == "{}" || !std::isfinite(value)) return NumberJson(value);
          return ordered_json(std::stod(fmt::format(fmt::runtime(format), value)));
        } else {
          return ordered_json(value);
        }
      },
      cell.value());
}

std::string DumpJson(const ordered_json& json) {
  return json.dump(2, ' ', false, ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace kerf
