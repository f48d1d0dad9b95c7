// Words for the parts of a tool that cut.
#pragma once

#include <string>
#include <string_view>

#include "kerf/tool.h"

namespace kerf {

struct ToolWords {
  std::string_view line;  // what the teeth of the model are pieces of, such as a drill's "lip"; empty: teeth are teeth
  std::string_view edge;  // where they are
};

ToolWords GetWords(const Tool& tool);
/// Returns "a tooth", or a tooth as a piece of a line, such as "0.5 mm of a lip".
std::string DescribeTooth(const Tool& tool);
/// Returns a number of teeth, such as "5.9 teeth" or "1.2 mm of the lips".
std::string DescribeTeeth(const Tool& tool, double teeth);

}  // namespace kerf
