#include "base/core/csv.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "base/core/foreign_format.h"
#include "base/core/nearest_name.h"
#include "base/core/printable.h"
#include "kerf/error.h"

namespace kerf {
namespace {

std::vector<std::string> SplitLine(std::string_view line, const CsvPlace& place) {
  std::vector<std::string> fields;
  std::size_t i = 0;
  while (true) {
    while (i < line.size() && (line[i] == ' ' || line[i] == '\t')) ++i;
    std::string field;
    if (i < line.size() && line[i] == '"') {
      ++i;
      while (true) {
        if (i >= line.size()) place.Fail("a field begins with a double quote that does not end on this line");
        if (line[i] == '"' && i + 1 < line.size() && line[i + 1] == '"') {
          field += '"';
          i += 2;
        } else if (line[i] == '"') {
          ++i;
          break;
        } else {
          field += line[i++];
        }
      }
      while (i < line.size() && (line[i] == ' ' || line[i] == '\t')) ++i;
      if (i < line.size() && line[i] != ',')
        place.Fail("text after a closing double quote; write a quote within a field as \"\"");
    } else {
      const std::size_t end = std::min(line.find(',', i), line.size());
      field = std::string(Trim(line.substr(i, end - i)));
      i = end;
    }
    fields.push_back(std::move(field));
    if (i >= line.size()) return fields;
    ++i;  // the comma
  }
}

/// Parses decimal text times 10^shift, rounded once. Returns nullopt unless the whole text is a finite number.
std::optional<double> ParseShifted(std::string_view text, int shift) {
  std::string scaled(text);
  if (shift != 0) {
    const auto e = text.find_first_of("eE");
    int exponent = 0;
    if (e != std::string_view::npos) {
      std::string_view digits = text.substr(e + 1);
      if (!digits.empty() && digits.front() == '+') digits.remove_prefix(1);
      const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), exponent);
      if (code != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
    }
    scaled = fmt::format("{}e{}", text.substr(0, e), exponent + shift);
  }
  double value = 0;
  const auto [end, code] = std::from_chars(scaled.data(), scaled.data() + scaled.size(), value);
  if (code != std::errc() || end != scaled.data() + scaled.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Returns true if a spreadsheet would treat the text, without leading apostrophes, as a formula. "-0.5" is excluded,
/// since it is just a number.
bool IsFormula(std::string_view text) {
  const auto first = text.find_first_not_of(" '");
  if (first == std::string_view::npos) return false;
  text.remove_prefix(first);
  return std::string_view("=+-@\t").find(text.front()) != std::string_view::npos && !ParseShifted(text, 0);
}

/// Returns the position of each of `columns` in the file, or the number of its columns for one that it lacks, which
/// must not be among the first `required` ones.
std::vector<std::size_t> ParseHeader(const std::vector<std::string>& names, const std::vector<std::string>& columns,
                                     std::size_t required, const CsvPlace& place) {
  const auto border = columns.begin() + static_cast<std::ptrdiff_t>(required);
  const std::string needed = fmt::format("{}", fmt::join(columns.begin(), border, ","));
  std::vector<std::size_t> position(columns.size(), names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::size_t column = 0;
    while (column < columns.size() && columns[column] != names[i]) ++column;
    if (column == columns.size()) {
      const std::string nearest = FindNearestName(names[i], columns);
      std::string list = "the columns are " + needed;
      if (border != columns.end()) list += fmt::format(" and, optionally, {}", fmt::join(border, columns.end(), ","));
      place.Fail(fmt::format("unknown column {}; {}{}", Quote(names[i]),
                             nearest.empty() ? list : fmt::format("did you mean \"{}\"?", nearest),
                             names.size() == 1 ? DescribeForeignTable(names[i]) : ""));
    }
    if (position[column] != names.size()) place.Fail(fmt::format("column \"{}\" is given twice", names[i]));
    position[column] = i;
  }
  for (std::size_t c = 0; c < required; ++c) {
    if (position[c] == names.size()) {
      place.Fail(fmt::format("column \"{}\" is missing; the header must be {}", columns[c], needed));
    }
  }
  return position;
}

}  // namespace

void CsvPlace::Fail(const std::string& what) const {
  throw Error(fmt::format("{}:{}: {}", file, line, what));
}

std::string_view Trim(std::string_view s) {
  const auto first = s.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t") - first + 1);
}

std::string Quote(std::string_view s) {
  return Printable(s.size() <= 60 ? fmt::format("\"{}\"", s) : fmt::format("\"{}...\"", s.substr(0, 57)));
}

CsvHeaderLine ReadCsvHeader(std::string_view text) {
  CsvHeaderLine header;
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);  // byte order mark of some spreadsheets
  while (!text.empty()) {
    ++header.line;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = Trim(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line = Trim(line.substr(0, line.size() - 1));
    if (line.empty() || line.front() == '#') continue;
    for (std::size_t from = 0; from <= line.size();) {
      const std::size_t to = std::min(line.find(',', from), line.size());
      std::string_view name = Trim(line.substr(from, to - from));
      if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
      header.names.emplace_back(name);
      from = to + 1;
    }
    return header;
  }
  return header;
}

void ReadCsv(const std::string& text, const std::string& file, const std::vector<std::string>& columns,
             const std::function<void(const std::vector<std::string>& fields, const CsvPlace& place)>& visit,
             const std::vector<std::string>& optional) {
  std::vector<std::string> all = columns;
  all.insert(all.end(), optional.begin(), optional.end());
  std::vector<std::size_t> position;
  std::size_t width = 0;  // of the file
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // byte order mark of some spreadsheets
  CsvPlace place{file, 0};
  std::vector<std::string> ordered(all.size());
  while (!rest.empty()) {
    ++place.line;
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const std::string_view trimmed = Trim(line);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    if (line.find('\0') != std::string_view::npos) place.Fail("the line is not text");
    std::vector<std::string> fields = SplitLine(line, place);
    for (std::string& field : fields) {
      if (field.starts_with('\'') && IsFormula(std::string_view(field).substr(1))) field.erase(0, 1);
    }
    if (position.empty()) {
      position = ParseHeader(fields, all, columns.size(), place);
      width = fields.size();
      continue;
    }
    if (fields.size() != width) {
      place.Fail(fmt::format("{} fields instead of {}; a field with a comma must be in double quotes{}", fields.size(),
                             width, fields.size() > width ? DescribeForeignTable(line) : ""));
    }
    for (std::size_t c = 0; c < all.size(); ++c) {
      ordered[c] = position[c] < width ? std::move(fields[position[c]]) : std::string();
    }
    visit(ordered, place);
  }
  if (position.empty()) throw Error(fmt::format("{}: no header; it must be {}", file, fmt::join(columns, ",")));
}

double ParseCsvNumber(std::string_view text, int shift, const char* name, const CsvPlace& place) {
  const std::optional<double> value = ParseShifted(text, shift);
  if (!value) place.Fail(fmt::format("{} = {} is not a number{}", name, Quote(text), DescribeForeignNumber(text)));
  return *value;
}

std::string FormatCsvNumber(double value, int shift) {
  std::string plain = fmt::format("{}", value / std::pow(10, shift));
  if (ParseShifted(plain, shift) == value) return plain;
  // The division lost the last digit, so write the unshifted value with a changed exponent.
  std::string digits = fmt::format("{:.17e}", value);
  const auto e = digits.find('e');
  int exponent = 0;
  std::string_view tail = std::string_view(digits).substr(e + 1);
  if (tail.front() == '+') tail.remove_prefix(1);
  std::from_chars(tail.data(), tail.data() + tail.size(), exponent);
  return fmt::format("{}e{}", digits.substr(0, e), exponent - shift);
}

std::string FormatCsvField(const std::string& text) {
  std::string line = text;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');  // a row is one line
  if (IsFormula(line)) line.insert(line.begin(), '\'');
  const bool plain = line.find_first_of(",\"") == std::string::npos && line == Trim(line) && !line.starts_with('#');
  if (plain) return line;
  std::string quoted = "\"";
  for (const char c : line) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + "\"";
}

}  // namespace kerf
