#include "app/window/saw_details.h"

#include <fmt/format.h>

#include <cmath>
#include <type_traits>
#include <variant>

#include "view/ui/translate.h"

namespace kerf {
namespace {

template <typename... Values>
std::string Format(const char* text, const Values&... values) {
  return fmt::format(fmt::runtime(text), values...);
}

/// Shows a number with as many of two decimals as it has.
std::string ShowShort(double value) {
  const auto is_whole = [](double v) { return std::abs(v - std::round(v)) < 1e-6; };
  return ShowNumber(value, is_whole(value) ? 0 : is_whole(10 * value) ? 1 : 2);
}

std::string ShowSize(const Tool& tool) {
  return std::visit(
      []<typename T>(const T& t) {
        if constexpr (std::is_same_v<T, OscillatingBlade>) {
          return Format(Tr("{} x {} mm, swing {} degrees"), ShowShort(t.radius_mm), ShowShort(t.width_mm),
                        ShowShort(t.swing_deg));
        } else if constexpr (requires { t.width_mm; }) {
          return Format(Tr("{} x {} mm, stroke {} mm"), ShowShort(t.length_mm), ShowShort(t.width_mm),
                        ShowShort(t.stroke_mm));
        } else if constexpr (requires { t.length_mm; }) {
          return Format(Tr("{} x {} mm"), ShowShort(t.diameter_mm), ShowShort(t.length_mm));
        } else if constexpr (requires { t.thickness_mm; }) {
          return Format(Tr("{} x {} mm"), ShowShort(t.diameter_mm), ShowShort(t.thickness_mm));
        } else {
          return Format(Tr("{} mm"), ShowShort(t.diameter_mm));
        }
      },
      tool);
}

/// Empty for a drill, which always has two lips.
std::string ShowTeeth(const Tool& tool) {
  return std::visit(
      [](const auto& t) -> std::string {
        if constexpr (requires { t.teeth(); }) return Format(Tr(", {} teeth"), ShowNumber(t.teeth(), 0));
        if constexpr (requires { t.teeth + 0; }) return Format(Tr(", {} teeth"), t.teeth);
        if constexpr (requires { t.flutes; }) return Format(Tr(", {} flutes"), t.flutes);
        return "";
      },
      tool);
}

std::string ShowRate(const SceneTool& tool) {
  constexpr double kLeastInKHz_per_min = 60e3;
  if (CalcStroke(tool.shape) == 0) return Format(Tr("{} rpm"), ShowNumber(tool.rpm, 0));
  if (tool.rpm < kLeastInKHz_per_min) return Format(Tr("{} double strokes a minute"), ShowNumber(tool.rpm, 0));
  return Format(Tr("{} kHz"), ShowShort(tool.rpm / kLeastInKHz_per_min));
}

}  // namespace

std::string ShowSawNumbers(const Saw& saw) {
  return ShowSize(saw.tool.shape) + ShowTeeth(saw.tool.shape) + ", " + ShowRate(saw.tool);
}

std::string ShowSawSource(const Saw& saw) {
  if (saw.source == "assumed") return Tr("Its numbers are assumed; they are typical.");
  return Format(Tr("Source of its numbers: {}"), saw.source);
}

}  // namespace kerf
