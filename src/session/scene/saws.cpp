#include "session/scene/saws.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <type_traits>

#include "base/core/csv.h"
#include "cut/tool/words.h"
#include "kerf/describe.h"
#include "kerf/error.h"
#include "saws_csv.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

constexpr std::size_t kLongestName = 30;

/// Columns that a table must have. The others that it may have are ListKeys().
const std::vector<std::string> kSawColumns{"name", "shape", "rpm", "source"};

/// Returns the keys of all shapes, each once.
const std::vector<std::string>& ListKeys() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> all;
    const auto add = [&all](const char* key, const auto&...) {
      if (std::find(all.begin(), all.end(), key) == all.end()) all.emplace_back(key);
    };
    for (Tool tool : GetDefaultTools()) {
      std::visit([&](auto& shape) { DescribeShape(shape, add); }, tool);
    }
    return all;
  }();
  return keys;
}

/// Fields of a row by the names of the columns that the table has.
using SawRow = std::map<std::string, std::string, std::less<>>;

double ParseWithin(const std::string& text, const char* key, Range range, const CsvPlace& place) {
  const double value = ParseCsvNumber(text, 0, key, place);
  if (const std::string fault = FindRangeFault(value, range, UnitOfKey(key)); !fault.empty()) {
    place.Fail(fmt::format("{} = {} {}", key, value, fault));
  }
  return value;
}

/// Takes the keys of the shape out of `row`. What is left of the other shapes' keys must be "none".
template <typename Shape>
void ParseShape(SawRow row, const CsvPlace& place, Shape& shape) {
  DescribeShape(shape, [&]<typename Value>(const char* key, Value& value, Range range, const char*) {
    const auto field = row.extract(key);
    if (field.empty()) return;  // the default
    const double number = ParseWithin(field.mapped(), key, range, place);
    if (std::is_integral_v<Value> && number != std::floor(number)) {
      place.Fail(fmt::format("{} = {} is not an integer", key, number));
    }
    value = static_cast<Value>(number);
  });
  for (const std::string& key : ListKeys()) {
    const auto field = row.find(key);
    if (field == row.end() || field->second == "none") continue;
    place.Fail(fmt::format("a {} has no {}; write none, not {}", row.at("shape"), key, Quote(field->second)));
  }
  try {
    shape.Validate();
  } catch (const Error& e) {
    place.Fail(e.what());
  }
}

Saw ParseSaw(const SawRow& row, const CsvPlace& place) {
  Saw saw{.name = row.at("name"), .tool = {}, .source = row.at("source")};
  if (saw.name.empty() || saw.name.size() > kLongestName) {
    place.Fail(fmt::format("name = {} must have 1 to {} characters", Quote(saw.name), kLongestName));
  }
  const std::string& word = row.at("shape");
  const std::vector<Tool>& tools = GetDefaultTools();
  const auto tool = std::find_if(tools.begin(), tools.end(), [&](const Tool& t) { return GetShape(t) == word; });
  if (tool == tools.end()) {
    place.Fail(fmt::format("shape = {} must be {}", Quote(word), fmt::join(GetToolShapes(), " or ")));
  }
  saw.tool.shape = *tool;
  std::visit([&](auto& shape) { ParseShape(row, place, shape); }, saw.tool.shape);
  saw.tool.rpm = ParseWithin(row.at("rpm"), "rpm", Range{kMinRpm, CalcRateRange(saw.tool.shape).upper}, place);
  if (saw.source.empty()) place.Fail("source is empty; give the source of the dimensions");
  return saw;
}

}  // namespace

std::vector<Saw> ParseSaws(const std::string& text, const std::string& file) {
  const std::vector<std::string> given = ReadCsvHeader(text).names;
  std::vector<std::string> columns = kSawColumns;
  columns.insert(columns.end(), ListKeys().begin(), ListKeys().end());
  std::vector<Saw> saws;
  const auto add = [&](const std::vector<std::string>& fields, const CsvPlace& place) {
    if (saws.size() == kMaxSaws) place.Fail(fmt::format("more than {} saws", kMaxSaws));
    SawRow row;
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (std::find(given.begin(), given.end(), columns[i]) != given.end()) row[columns[i]] = fields[i];
    }
    Saw saw = ParseSaw(row, place);
    for (const Saw& other : saws) {
      if (other.name == saw.name) place.Fail(fmt::format("saw {} is given twice", Quote(saw.name)));
    }
    saws.push_back(std::move(saw));
  };
  ReadCsv(text, file, kSawColumns, add, ListKeys());
  if (saws.empty()) throw Error(fmt::format("{}: no saw below the header", file));
  return saws;
}

const std::vector<Saw>& BuiltInSaws() {
  static const std::vector<Saw> saws = ParseSaws(kSawsCsv, "saws.csv (built in)");
  return saws;
}

std::string DescribeRate(const SceneTool& tool) {
  return fmt::format("{} {}", tool.rpm, CalcStroke(tool.shape) > 0 ? "double strokes a minute" : "rpm");
}

std::string DescribeSense(const SceneTool& tool) {
  if (GetDrive(tool.shape) != DriveMotion::kRotation) return "";
  return fmt::format("{}clockwise as seen from the handpiece", tool.CalcTickRpm(1) < 0 ? "" : "counter-");
}

std::string DescribeDrivenTool(const SceneTool& tool) {
  const std::string sense = DescribeSense(tool);
  return fmt::format("{}, {}{}{}", DescribeTool(tool.shape), DescribeRate(tool), sense.empty() ? "" : ", ", sense);
}

void UseSaw(Scene& scene, const Saw& saw) {
  const Tool before = scene.tool.shape;
  scene.tool = saw.tool;
  // A handpiece that turns its tool is held above it. Where one with a stroke is held depends on the kind of its blade.
  const Tool& after = saw.tool.shape;
  if (GetDrive(before) == GetDrive(after) && (CalcStroke(after) == 0 || before.index() == after.index())) {
    std::visit([&](auto& shape) { shape.p_TG_mm = CalcGrip(before); }, scene.tool.shape);
  }
  if (!std::holds_alternative<DiscSaw>(saw.tool.shape)) scene.slab = {};
}

}  // namespace kerf
