#include "material/region_table.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include "core/nearest_name.h"
#include "kerf/error.h"
#include "mandible_regions_csv.h"

namespace kerf {
namespace {

enum Column { kId, kName, kTissue, kE, kNu, kEstimate, kSource, kColumnCount };
const std::vector<std::string> kColumns = {"id", "name", "tissue", "E_GPa", "nu", "estimate", "source"};

/// Where a fault stands: "file:line".
struct Place {
  const std::string& file;
  int line;

  [[noreturn]] void Fail(const std::string& what) const { throw Error(fmt::format("{}:{}: {}", file, line, what)); }
};

std::string_view Trim(std::string_view s) {
  const auto first = s.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(" \t") - first + 1);
}

/// What the user typed, short enough for a message.
std::string Quote(std::string_view s) {
  return s.size() <= 60 ? fmt::format("\"{}\"", s) : fmt::format("\"{}...\"", s.substr(0, 57));
}

std::vector<std::string> SplitLine(std::string_view line, const Place& place) {
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

/// Decimal text times 10^shift, rounded once; nothing unless all of the text is a finite number.
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

double ParseNumber(std::string_view text, int shift, const char* column, const Place& place) {
  const std::optional<double> value = ParseShifted(text, shift);
  if (!value) place.Fail(fmt::format("{} = {} is not a number", column, Quote(text)));
  return *value;
}

/// Position of each column in the file's own order.
std::vector<std::size_t> ParseHeader(const std::vector<std::string>& names, const Place& place) {
  std::vector<std::size_t> position(kColumnCount, names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::size_t column = 0;
    while (column < kColumns.size() && kColumns[column] != names[i]) ++column;
    if (column == kColumns.size()) {
      const std::string nearest = FindNearestName(names[i], kColumns);
      place.Fail(fmt::format("unknown column {}; {}", Quote(names[i]),
                             nearest.empty() ? fmt::format("the columns are {}", fmt::join(kColumns, ","))
                                             : fmt::format("did you mean \"{}\"?", nearest)));
    }
    if (position[column] != names.size()) place.Fail(fmt::format("column \"{}\" is given twice", names[i]));
    position[column] = i;
  }
  for (std::size_t c = 0; c < kColumns.size(); ++c) {
    if (position[c] == names.size()) {
      place.Fail(fmt::format("column \"{}\" is missing; the header is {}", kColumns[c], fmt::join(kColumns, ",")));
    }
  }
  return position;
}

Region ParseRow(const std::vector<std::string>& fields, const std::vector<std::size_t>& position, const Place& place) {
  const auto field = [&](Column c) -> const std::string& { return fields[position[c]]; };
  Region region;
  const std::string& id = field(kId);
  const auto [end, code] = std::from_chars(id.data(), id.data() + id.size(), region.id);
  if (code != std::errc() || end != id.data() + id.size()) {
    place.Fail(fmt::format("id = {} is not a whole number within 1 to 255", Quote(id)));
  }
  region.name = field(kName);
  if (region.name.empty()) place.Fail("name is empty");
  const std::optional<Tissue> tissue = TissueFromString(field(kTissue));
  if (!tissue) {
    place.Fail(fmt::format("tissue = {} is none of cortical, cancellous, tooth, canal, other", Quote(field(kTissue))));
  }
  region.tissue = *tissue;
  region.E_MPa = ParseNumber(field(kE), 3, "E_GPa", place);
  region.nu = ParseNumber(field(kNu), 0, "nu", place);
  const std::string& estimate = field(kEstimate);
  if (estimate != "yes" && estimate != "no") {
    place.Fail(fmt::format("estimate = {} is neither yes nor no", Quote(estimate)));
  }
  region.estimate = estimate == "yes";
  region.source = field(kSource);
  if (region.source.empty()) place.Fail("source is empty; say where the figures come from");
  return region;
}

std::string FormatField(const std::string& text) {
  const bool plain = text.find_first_of(",\"") == std::string::npos && text == Trim(text) && !text.starts_with('#');
  if (plain) return text;
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c == '\n' || c == '\r' ? ' ' : c;  // a row is one line
  }
  return quoted + "\"";
}

std::string FormatGPa(double E_MPa) {
  std::string plain = fmt::format("{}", E_MPa / 1000);
  if (ParseShifted(plain, 3) == E_MPa) return plain;
  // Dividing rounded away the last digit: say it in MPa with the exponent moved.
  std::string digits = fmt::format("{:.17e}", E_MPa);
  const auto e = digits.find('e');
  int exponent = 0;
  std::string_view tail = std::string_view(digits).substr(e + 1);
  if (tail.front() == '+') tail.remove_prefix(1);
  std::from_chars(tail.data(), tail.data() + tail.size(), exponent);
  return fmt::format("{}e{}", digits.substr(0, e), exponent - 3);
}

}  // namespace

MaterialTable ParseRegionTable(const std::string& text, const std::string& file) {
  MaterialTable table;
  std::vector<std::size_t> position;
  std::string_view rest = text;
  if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);  // as some spreadsheets write it
  Place place{file, 0};
  while (!rest.empty()) {
    ++place.line;
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const std::string_view trimmed = Trim(line);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    if (line.find('\0') != std::string_view::npos) place.Fail("this is not text");
    const std::vector<std::string> fields = SplitLine(line, place);
    if (position.empty()) {
      position = ParseHeader(fields, place);
      continue;
    }
    if (fields.size() != kColumnCount) {
      place.Fail(fmt::format("{} fields instead of {}; a field with a comma stands in double quotes", fields.size(),
                             static_cast<int>(kColumnCount)));
    }
    Region region = ParseRow(fields, position, place);
    try {
      table.Add(std::move(region));
    } catch (const Error& e) {
      place.Fail(e.what());
    }
  }
  if (position.empty()) throw Error(fmt::format("{}: no header; it is {}", file, fmt::join(kColumns, ",")));
  if (table.empty()) throw Error(fmt::format("{}: no region below the header", file));
  return table;
}

std::string FormatRegionTable(const MaterialTable& table) {
  std::string text = fmt::format("{}\n", fmt::join(kColumns, ","));
  for (const auto& [id, region] : table.regions()) {
    text += fmt::format("{},{},{},{},{},{},{}\n", id, FormatField(region.name), ToString(region.tissue),
                        FormatGPa(region.E_MPa), region.nu, region.estimate ? "yes" : "no", FormatField(region.source));
  }
  return text;
}

const MaterialTable& DefaultMandibleTable() {
  static const MaterialTable table = ParseRegionTable(kMandibleRegionsCsv, "volumes/mandible_regions.csv");
  return table;
}

}  // namespace kerf
