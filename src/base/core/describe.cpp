#include "kerf/describe.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "kerf/error.h"

namespace kerf {

std::string_view UnitOfKey(std::string_view key) {
  // Longer endings first.
  static constexpr auto kEndings = std::to_array<std::pair<std::string_view, std::string_view>>({
      {"_Nmm_per_rad", "N mm/rad"},
      {"_Ns_per_mm", "N s/mm"},
      {"_mL_per_min_kg", "mL/min/kg"},
      {"_W_per_m2K", "W/m2K"},
      {"_W_per_mK", "W/mK"},
      {"_J_per_kgK", "J/kgK"},
      {"_kg_per_m3", "kg/m3"},
      {"_mg_per_mm3", "mg/mm3"},
      {"_J_per_mm3", "J/mm3"},
      {"_N_per_mm2", "N/mm2"},
      {"_N_per_mm", "N/mm"},
      {"_mm_per_s", "mm/s"},
      {"_m_per_s2", "m/s2"},
      {"_N_per_s", "N/s"},
      {"_Nmms", "N mm s"},
      {"_Nmm", "N mm"},
      {"_gmm2", "g mm2"},
      {"_mm3", "mm3"},
      {"_mm2", "mm2"},
      {"_mm", "mm"},
      {"_GPa", "GPa"},
      {"_MPa", "MPa"},
      {"_deg", "degrees"},
      {"_hz", "Hz"},
      {"_Hz", "Hz"},
      {"_um", "um"},
      {"_MB", "MB"},
      {"_px", "pixels"},
      {"_hu", "HU"},
      {"_us", "us"},
      {"_ms", "ms"},
      {"_s", "s"},
      {"_g", "g"},
      {"_N", "N"},
      {"_W", "W"},
      {"_C", "C"},
      {"rpm", "rpm"},
      {"seconds", "s"},
  });
  for (const auto& [ending, unit] : kEndings) {
    if (key.size() >= ending.size() && key.substr(key.size() - ending.size()) == ending) return unit;
  }
  return {};
}

std::string ShowRange(Range range, std::string_view unit) {
  return fmt::format("{} to {}{}{}{}", range.lower, range.upper, unit.empty() ? "" : " ", unit,
                     range.or_zero ? ", or 0" : "");
}

std::string FindRangeFault(double value, Range range, std::string_view unit) {
  if (range.Contains(value)) return {};
  const std::string problem = !std::isfinite(value) ? "is not a finite number"
                              : value < range.lower ? fmt::format("is below {}", range.lower)
                                                    : fmt::format("is above {}", range.upper);
  return fmt::format("{}; valid range {}", problem, ShowRange(range, unit));
}

void CheckRange(std::string_view key, double value, Range range, std::string_view whose) {
  const std::string fault = FindRangeFault(value, range, UnitOfKey(key.substr(0, key.find('['))));
  if (fault.empty()) return;
  throw Error(fmt::format("{}{}{} = {} {}", whose, whose.empty() ? "" : ": ", key, value, fault));
}

void ParameterChecker::operator()(const char* key, Vec3& value, Range range, const char*) const {
  for (int i = 0; i < 3; ++i) CheckRange(fmt::format("{}[{}]", key, i), value[i], range, whose_);
}

void ParameterChecker::operator()(const char* key, std::string& value, const Choices& choices, const char*) const {
  if (std::find(choices.words.begin(), choices.words.end(), value) != choices.words.end()) return;
  throw Error(fmt::format("{}{}{} = \"{}\" is unknown; it must be \"{}\"", whose_, whose_.empty() ? "" : ": ", key,
                          value, fmt::join(choices.words, "\" or \"")));
}

Range RangeFinder::Get() const {
  if (!range_) throw Error(fmt::format("there is no parameter {}", key_));
  return *range_;
}

}  // namespace kerf
