#include "base/core/number_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kerf {

std::string FormatVolume(double mm3) {
  // From 999.5, three digits would be printed as 1e+03.
  return mm3 < 999.5 ? fmt::format("{:.3g} mm3", mm3) : fmt::format("{:.2f} cm3", mm3 / 1000);
}

ShownVolume ChooseVolumeUnit(double mm3) {
  if (mm3 < 999.95) return {mm3, 1, "mm³"};
  return {1e-3 * mm3, 2, "cm³"};
}

std::string ShowThree(double value) {
  if (!std::isfinite(value)) return "not a number";
  if (value == 0) return "0";
  const int digits = static_cast<int>(std::floor(std::log10(std::abs(value)) + 1e-12));
  return digits < -6 ? fmt::format("{:.2e}", value) : fmt::format("{:.{}f}", value, std::clamp(2 - digits, 0, 9));
}

std::string FormatLength(double mm) {
  if (std::abs(mm) > 1e6) return mm > 0 ? "more than 1 km" : "less than -1 km";
  return fmt::format("{:.0f} mm", std::nearbyint(mm) + 0.0);  // + 0.0 removes the sign of a zero
}

std::string FormatCount(std::size_t count, const std::string& one, const std::string& many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

}  // namespace kerf
