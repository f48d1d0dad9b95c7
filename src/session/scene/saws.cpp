#include "session/scene/saws.h"

#include <fmt/format.h>

#include <cmath>

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

double ParseWithin(const std::string& text, std::size_t column, Range range, const CsvPlace& place) {
  const double value = ParseCsvNumber(text, 0, kSawColumns[column].c_str(), place);
  if (const std::string fault = FindRangeFault(value, range, UnitOfKey(kSawColumns[column])); !fault.empty()) {
    place.Fail(fmt::format("{} = {} {}", kSawColumns[column], value, fault));
  }
  return value;
}

int ParseCount(const std::string& text, std::size_t column, Range range, const CsvPlace& place) {
  const double value = ParseWithin(text, column, range, place);
  if (value != std::floor(value)) place.Fail(fmt::format("{} = {} is not an integer", kSawColumns[column], value));
  return static_cast<int>(value);
}

void ExpectNone(const std::string& text, std::size_t column, const char* shape, const CsvPlace& place) {
  if (text != "none") {
    place.Fail(fmt::format("a {} has no {}; write none, not {}", shape, kSawColumns[column], Quote(text)));
  }
}

Saw ParseSaw(const std::vector<std::string>& fields, const CsvPlace& place) {
  Saw saw;
  saw.name = fields[0];
  if (saw.name.empty() || saw.name.size() > kLongestName) {
    place.Fail(fmt::format("name = {} must have 1 to {} characters", Quote(saw.name), kLongestName));
  }
  if (fields[1] == "disc") {
    saw.tool.diameter_mm = ParseWithin(fields[2], 2, FindRange<DiscSaw>(kSawColumns[2]), place);
    saw.tool.thickness_mm = ParseWithin(fields[3], 3, FindRange<DiscSaw>(kSawColumns[3]), place);
    saw.tool.teeth = ParseCount(fields[4], 4, FindRange<DiscSaw>(kSawColumns[4]), place);
    ExpectNone(fields[5], 5, "disc", place);
  } else if (fields[1] == "ball") {
    saw.tool.kind = ToolKind::kBall;
    saw.tool.diameter_mm = ParseWithin(fields[2], 2, FindRange<BallBurr>(kSawColumns[2]), place);
    ExpectNone(fields[3], 3, "ball", place);
    ExpectNone(fields[4], 4, "ball", place);
    saw.tool.flutes = ParseCount(fields[5], 5, FindRange<BallBurr>(kSawColumns[5]), place);
  } else {
    place.Fail(fmt::format("shape = {} must be disc or ball", Quote(fields[1])));
  }
  saw.tool.rpm = ParseWithin(fields[6], 6, Range{kMinRpm, kSpindleRange_rpm.upper}, place);
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
  const Vec3 grip_mm = scene.tool.grip_mm;
  scene.tool = saw.tool;
  scene.tool.grip_mm = grip_mm;
  if (saw.tool.kind == ToolKind::kBall) scene.slab = {};
}

}  // namespace kerf
