#include "bone/material/ct_law_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/core/csv.h"
#include "base/core/nearest_name.h"
#include "ct_laws_csv.h"
#include "kerf/error.h"

namespace kerf {
namespace {

enum LawColumn { kLawName, kLawTissue, kLawDensity, kLawCalibration, kLawBands, kLawTag, kLawSource };
const std::vector<std::string> kLawColumns = {"name", "tissue", "density", "calibration", "bands", "tag", "source"};
constexpr std::array<const char*, 4> kDensities = {"apparent", "ash", "qct", "mass"};
constexpr std::size_t kMaxParts = 100;  // maximum number of points of a calibration, or of bands
constexpr std::size_t kMaxLaws = 1000;
constexpr std::size_t kMaxName = 40;

/// Returns the trimmed parts between separators; omits empty parts if the separator is a blank.
std::vector<std::string_view> Split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  while (true) {
    const std::size_t end = std::min(text.find(separator), text.size());
    const std::string_view part = Trim(text.substr(0, end));
    if (!part.empty() || separator != ' ') parts.push_back(part);
    if (end == text.size()) return parts;
    text.remove_prefix(end + 1);
  }
}

std::vector<CtLaw::Point> ParsePoints(std::string_view text, const CsvPlace& place) {
  const std::vector<std::string_view> parts = Split(text, ' ');
  if (parts.size() > kMaxParts) place.Fail(fmt::format("the calibration has more than {} points", kMaxParts));
  std::vector<CtLaw::Point> points;
  for (const std::string_view part : parts) {
    const std::size_t colon = part.find(':');
    if (colon == std::string_view::npos) {
      place.Fail(fmt::format("calibration point {} is not HU:density, such as 1000:1.2", Quote(part)));
    }
    points.push_back({ParseCsvNumber(part.substr(0, colon), 0, "HU", place),
                      ParseCsvNumber(part.substr(colon + 1), 0, "density", place)});
  }
  return points;
}

/// Parses a band such as "0.8 to 1.8: 1157.1 rho^1.78" or "0.1 to 0.4: -34.7 + 3230 rho^1".
CtLaw::Band ParseBand(std::string_view text, const CsvPlace& place) {
  const std::vector<std::string_view> words = Split(text, ' ');
  constexpr std::string_view kPower = "rho^";
  const bool offset = words.size() == 7 && words[4] == "+";
  if (!(offset || words.size() == 5) || words[1] != "to" || !words[2].ends_with(':') ||
      !words.back().starts_with(kPower)) {
    place.Fail(
        fmt::format("band {} is not written as LOWER to UPPER: A rho^B or LOWER to UPPER: C + A rho^B, such as "
                    "0.8 to 1.8: 1157.1 rho^1.78",
                    Quote(text)));
  }
  CtLaw::Band band{};
  band.lower = ParseCsvNumber(words[0], 0, "lower density", place);
  band.upper = ParseCsvNumber(words[2].substr(0, words[2].size() - 1), 0, "upper density", place);
  if (offset) band.E0_MPa = ParseCsvNumber(words[3], 0, "offset", place);
  band.a_MPa = ParseCsvNumber(words[offset ? 5 : 3], 0, "coefficient", place);
  band.b = ParseCsvNumber(words.back().substr(kPower.size()), 0, "exponent", place);
  return band;
}

CtLaw ParseLawRow(const std::vector<std::string>& fields, const CsvPlace& place) {
  CtLaw law;
  law.name = fields[kLawName];
  const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
  if (law.name.empty() || law.name.size() > kMaxName || !std::all_of(law.name.begin(), law.name.end(), plain)) {
    place.Fail(fmt::format("name = {} must be 1 to {} lower-case letters, digits and _", Quote(law.name), kMaxName));
  }
  law.tissue = fields[kLawTissue];
  if (law.tissue.empty()) place.Fail("tissue is empty; state the bone for which the law was made");
  law.density = fields[kLawDensity];
  if (std::find(kDensities.begin(), kDensities.end(), law.density) == kDensities.end()) {
    place.Fail(fmt::format("density = {} is not one of {}", Quote(law.density), fmt::join(kDensities, ", ")));
  }
  if (fields[kLawCalibration] != "none") {
    law.calibration = ParsePoints(fields[kLawCalibration], place);
    if (law.calibration.empty()) place.Fail("calibration is empty; write HU:density points, or none");
  }
  const std::vector<std::string_view> bands = Split(fields[kLawBands], ';');
  if (bands.size() > kMaxParts) place.Fail(fmt::format("more than {} bands", kMaxParts));
  for (const std::string_view band : bands) law.bands.push_back(ParseBand(band, place));
  if (fields[kLawTag] != "S" && fields[kLawTag] != "D" && fields[kLawTag] != "R") {
    place.Fail(fmt::format("tag = {} is not one of S (read in the source), D (derived) and R (recalled, unverified)",
                           Quote(fields[kLawTag])));
  }
  law.tag = fields[kLawTag][0];
  law.source = fields[kLawSource];
  if (law.source.empty()) place.Fail("source is empty; state where the numbers come from");
  try {
    CheckCtLaw(law);
  } catch (const Error& e) {
    place.Fail(fmt::format("{}: {}", law.name, e.what()));
  }
  return law;
}

std::string FormatBand(const CtLaw::Band& band) {
  const std::string offset = band.E0_MPa != 0 ? fmt::format("{} + ", band.E0_MPa) : "";
  return fmt::format("{} to {}: {}{} rho^{}", band.lower, band.upper, offset, band.a_MPa, band.b);
}

}  // namespace

std::vector<CtLaw> ParseCtLaws(const std::string& text, const std::string& file) {
  std::vector<CtLaw> laws;
  ReadCsv(text, file, kLawColumns, [&laws](const std::vector<std::string>& fields, const CsvPlace& place) {
    if (laws.size() == kMaxLaws) place.Fail(fmt::format("more than {} laws", kMaxLaws));
    CtLaw law = ParseLawRow(fields, place);
    for (const CtLaw& other : laws) {
      if (other.name == law.name) place.Fail(fmt::format("law \"{}\" is given twice", law.name));
    }
    laws.push_back(std::move(law));
  });
  if (laws.empty()) throw Error(fmt::format("{}: no law below the header", file));
  return laws;
}

std::string FormatCtLaws(const std::vector<CtLaw>& laws) {
  std::string text = fmt::format("{}\n", fmt::join(kLawColumns, ","));
  for (const CtLaw& law : laws) {
    std::string bands;
    for (const CtLaw::Band& band : law.bands) bands += (bands.empty() ? "" : "; ") + FormatBand(band);
    text += fmt::format("{},{},{},{},{},{},{}\n", law.name, FormatCsvField(law.tissue), law.density,
                        law.calibration.empty() ? "none" : FormatCalibration(law.calibration), bands, law.tag,
                        FormatCsvField(law.source));
  }
  return text;
}

std::vector<CtLaw::Point> ParseCalibration(const std::string& text) {
  const std::string name = "ct_calibration";
  try {
    return ParsePoints(text, CsvPlace{name, 1});
  } catch (const Error& e) {
    // The text has only one line, so its number is removed from the message.
    throw Error(std::string(e.what()).substr(name.size() + 4));
  }
}

std::string FormatCalibration(const std::vector<CtLaw::Point>& points) {
  std::string text;
  for (const CtLaw::Point& p : points) text += fmt::format("{}{}:{}", text.empty() ? "" : " ", p.HU, p.rho);
  return text;
}

const std::vector<CtLaw>& DefaultCtLaws() {
  static const std::vector<CtLaw> laws = ParseCtLaws(kCtLawsCsv, "volumes/ct_laws.csv");
  return laws;
}

const CtLaw& FindCtLaw(const std::vector<CtLaw>& laws, const std::string& name) {
  std::vector<std::string> names;
  for (const CtLaw& law : laws) {
    if (law.name == name) return law;
    names.push_back(law.name);
  }
  const std::string nearest = FindNearestName(name, names);
  throw Error(fmt::format("ct_law = {} is unknown; {}", Quote(name),
                          nearest.empty() ? fmt::format("the laws are {}", fmt::join(names, ", "))
                                          : fmt::format("the nearest is \"{}\"", nearest)));
}

CtLaw WithCalibration(CtLaw law, const std::string& calibration) {
  if (!calibration.empty()) law.calibration = ParseCalibration(calibration);
  if (law.calibration.empty()) {
    throw Error(
        fmt::format("ct_law = \"{}\" requires {} density and has no calibration of its own, since that depends on "
                    "the scanner; give ct_calibration = \"HU:density HU:density ...\" in g/cm3, from a phantom",
                    law.name, law.density));
  }
  CheckCtLaw(law);
  return law;
}

}  // namespace kerf
