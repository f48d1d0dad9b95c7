#include "session/scene/saws.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "base/core/csv.h"
#include "kerf/describe.h"
#include "kerf/error.h"
#include "saws_csv.h"
#include "session/scene/schema.h"

namespace kerf {
namespace {

constexpr std::size_t kMaxSaws = 9;  // each is selected with one key
constexpr std::size_t kLongestName = 30;

const std::vector<std::string> kSawColumns{"name",  "shape",  "diameter_mm", "thickness_mm",
                                           "teeth", "flutes", "rpm",         "source"};
constexpr std::size_t kRpmColumn = 6;

double ParseWithin(const std::string& text, std::size_t column, Range range, const CsvPlace& place) {
  const double value = ParseCsvNumber(text, 0, kSawColumns[column].c_str(), place);
  if (const std::string fault = FindRangeFault(value, range, UnitOfKey(kSawColumns[column])); !fault.empty()) {
    place.Fail(fmt::format("{} = {} {}", kSawColumns[column], value, fault));
  }
  return value;
}

/// Reads the columns that the shape has; the others must be "none".
template <typename Shape>
void ParseShape(const std::vector<std::string>& fields, const CsvPlace& place, Shape& shape) {
  for (std::size_t column = 2; column < kRpmColumn; ++column) {
    bool has = false;
    DescribeShape(shape, [&](const char* key, auto& value, Range range, const char*) {
      if (key != kSawColumns[column]) return;
      has = true;
      const double number = ParseWithin(fields[column], column, range, place);
      if (std::is_integral_v<std::remove_reference_t<decltype(value)>> && number != std::floor(number)) {
        place.Fail(fmt::format("{} = {} is not an integer", kSawColumns[column], number));
      }
      value = static_cast<std::remove_reference_t<decltype(value)>>(number);
    });
    if (!has && fields[column] != "none") {
      place.Fail(
          fmt::format("a {} has no {}; write none, not {}", fields[1], kSawColumns[column], Quote(fields[column])));
    }
  }
}

Saw ParseSaw(const std::vector<std::string>& fields, const CsvPlace& place) {
  Saw saw;
  saw.name = fields[0];
  if (saw.name.empty() || saw.name.size() > kLongestName) {
    place.Fail(fmt::format("name = {} must have 1 to {} characters", Quote(saw.name), kLongestName));
  }
  const std::vector<Tool>& tools = GetDefaultTools();
  const auto tool = std::find_if(tools.begin(), tools.end(), [&](const Tool& t) { return GetShape(t) == fields[1]; });
  if (tool == tools.end()) {
    place.Fail(fmt::format("shape = {} must be {}", Quote(fields[1]), fmt::join(GetToolShapes(), " or ")));
  }
  saw.tool.shape = *tool;
  std::visit([&](auto& shape) { ParseShape(fields, place, shape); }, saw.tool.shape);
  saw.tool.rpm = ParseWithin(fields[kRpmColumn], kRpmColumn, Range{kMinRpm, kSpindleRange_rpm.upper}, place);
  saw.source = fields[7];
  if (saw.source.empty()) place.Fail("source is empty; give the source of the dimensions");
  return saw;
}

}  // namespace

std::vector<Saw> ParseSaws(const std::string& text, const std::string& file) {
  std::vector<Saw> saws;
  ReadCsv(text, file, kSawColumns, [&saws](const std::vector<std::string>& fields, const CsvPlace& place) {
    if (saws.size() == kMaxSaws) place.Fail(fmt::format("more than {} saws", kMaxSaws));
    Saw saw = ParseSaw(fields, place);
    for (const Saw& other : saws) {
      if (other.name == saw.name) place.Fail(fmt::format("saw {} is given twice", Quote(saw.name)));
    }
    saws.push_back(std::move(saw));
  });
  if (saws.empty()) throw Error(fmt::format("{}: no saw below the header", file));
  return saws;
}

const std::vector<Saw>& BuiltInSaws() {
  static const std::vector<Saw> saws = ParseSaws(kSawsCsv, "saws.csv (built in)");
  return saws;
}

void UseSaw(Scene& scene, const Saw& saw) {
  const Vec3 p_TG_mm = CalcGrip(scene.tool.shape);
  scene.tool = saw.tool;
  std::visit([&](auto& shape) { shape.p_TG_mm = p_TG_mm; }, scene.tool.shape);
  if (!std::holds_alternative<DiscSaw>(saw.tool.shape)) scene.slab = {};
}

}  // namespace kerf
