#include "cut/tool/words.h"

#include <fmt/format.h>

#include "cut/tool/kinds.h"

namespace kerf {

ToolWords GetWords(const Tool& tool) {
  return CallKind(tool, [](auto kind, const auto&) { return kind.kWords; });
}

std::string DescribeTooth(const Tool& tool) {
  const std::string_view line = GetWords(tool).line;
  return line.empty() ? "a tooth" : fmt::format("{:.3g} mm of a {}", CalcTooth(tool).width_mm, line);
}

std::string DescribeTeeth(const Tool& tool, double teeth) {
  const std::string_view line = GetWords(tool).line;
  if (line.empty()) return fmt::format("{:.1f} teeth", teeth);
  return fmt::format("{:.1f} mm of the {}s", teeth * CalcTooth(tool).width_mm, line);
}

}  // namespace kerf
