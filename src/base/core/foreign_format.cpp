#include "base/core/foreign_format.h"

#include <fmt/format.h>

#include <utility>

namespace kerf {

std::string DescribeForeignNumber(std::string_view text) {
  const bool is_foreign = text.find_first_of(",;") != text.npos;
  if (!is_foreign || text.find_first_not_of("0123456789.,;+-eE ") != text.npos) return "";
  return fmt::format("; {}: export the file again with English number format",
                     text.find(';') != text.npos ? "its numbers are separated by semicolons"
                                                 : "its numbers have a decimal comma instead of a point");
}

std::string DescribeForeignTable(std::string_view line) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const bool has_comma = line.find(',') != line.npos;
  for (const auto& [mark, name] : {std::pair{';', "semicolons"}, std::pair{'\t', "tabs"}}) {
    if (has_comma || line.find(mark) == line.npos) continue;
    return fmt::format("; the columns are separated by {}: save the table again with commas and decimal points", name);
  }
  // A field that begins with a digit behind one that is a whole number.
  for (std::size_t i = 1; i + 1 < line.size(); ++i) {
    if (line[i] != ',' || !is_digit(line[i - 1]) || !is_digit(line[i + 1])) continue;
    const std::size_t begin = line.find_last_not_of("0123456789", i - 1);
    if (begin == line.npos || std::string_view(",-+;\"").find(line[begin]) != std::string_view::npos) {
      return "; if the numbers have decimal commas, save the table again with decimal points";
    }
  }
  return "";
}

}  // namespace kerf
