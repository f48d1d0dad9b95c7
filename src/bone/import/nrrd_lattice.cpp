#include "bone/import/nrrd_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <vector>

#include "bone/import/patient_frame.h"
#include "kerf/error.h"

namespace kerf {

namespace {

// Parses text such as "(1,0,0) (0,1,0) none": a vector for each axis of the array.
std::vector<std::optional<Vec3>> ParseVectors(const std::string& text, const std::string& path) {
  std::vector<std::optional<Vec3>> vectors;
  std::size_t at = 0;
  while ((at = text.find_first_not_of(" \t", at)) != std::string::npos) {
    if (Lower(text.substr(at, 4)) == "none") {
      vectors.emplace_back();
      at += 4;
      continue;
    }
    const std::size_t end = text.find(')', at);
    std::vector<double> numbers;
    if (text[at] == '(' && end != std::string::npos) {
      std::string inside = text.substr(at + 1, end - at - 1);
      std::replace(inside.begin(), inside.end(), ',', ' ');
      numbers = ParseNumbers(inside);
    }
    if (numbers.size() != 3) {
      throw Error(
          fmt::format("{}: '{}' in the NRRD header should be vectors of three numbers, such as (1,0,0)", path, text));
    }
    vectors.emplace_back(Vec3(numbers[0], numbers[1], numbers[2]));
    at = end + 1;
  }
  return vectors;
}

// Returns the first word, quoted or not; all words must be equal.
std::string ParseUnit(const std::string& text, const std::string& path) {
  std::vector<std::string> units;
  std::string word;
  for (const char c : text + " ") {
    if (c != '"' && c != ' ') {
      word += c;
    } else if (!word.empty()) {
      units.push_back(word);
      word.clear();
    }
  }
  if (units.empty()) return "";
  if (std::any_of(units.begin(), units.end(), [&units](const std::string& u) { return u != units.front(); })) {
    throw Error(fmt::format("{}: the header gives its axes different units: {}", path, text));
  }
  return units.front();
}

double UnitLength(const std::string& unit, const std::string& path) {
  static const std::map<std::string, double> kUnitLengths_mm = {
      {"", 1},           {"?", 1},          {"mm", 1},  {"millimeter", 1},  {"millimeters", 1}, {"m", 1000},
      {"meter", 1000},   {"meters", 1000},  {"cm", 10}, {"centimeter", 10}, {"um", 0.001},      {"\xc2\xb5m", 0.001},
      {"micron", 0.001}, {"microns", 0.001}};
  const auto known = kUnitLengths_mm.find(Lower(unit));
  if (known != kUnitLengths_mm.end()) return known->second;
  throw Error(
      fmt::format("{}: the header's unit of length '{}' is unknown; kerf accepts m, cm, mm and um", path, unit));
}

// Returns the frame that corresponds to the header's space.
std::string FindFrame(const ImageFields& fields, const std::string& path, std::vector<std::string>& warnings) {
  static const std::map<std::string, std::string> kPatient = {
      {"rightanteriorsuperior", "RAS"}, {"ras", "RAS"}, {"leftanteriorsuperior", "LAS"}, {"las", "LAS"}, {"lps", "LPS"},
      {"leftposteriorsuperior", "LPS"}};
  const std::string space = fields.Get("space");
  std::string key = Lower(space);
  key.erase(std::remove_if(key.begin(), key.end(), [](char c) { return c == '-' || c == ' '; }), key.end());
  if (const auto known = kPatient.find(key); known != kPatient.end()) return known->second;
  if (key.empty()) {
    warnings.emplace_back(
        "the NRRD header names no space, so the orientation of the scan in the patient is unknown; its coordinates "
        "were taken as LPS (left, back, head), and left and right may be swapped; set them with --frame");
  } else if (key == "scannerxyz") {
    warnings.push_back(fmt::format(
        "the NRRD header's space '{}' is the scanner's, not the patient's; LPS was assumed, as for a patient lying on "
        "the back, head first; to change it, use --frame",
        space));
  } else if (key == "3drighthanded") {
    warnings.push_back(fmt::format(
        "the NRRD header's space '{}' does not say how the scan lies in the patient; its coordinates were taken as LPS "
        "(left, back, head); to change this, use --frame",
        space));
  } else if (key == "3dlefthanded") {
    throw Error(fmt::format(
        "{}: the NRRD header's space '{}' does not say how the scan lies in the patient, and a left-handed one can't "
        "be taken as LPS, which is right-handed; specify where x, y and z point with --frame, such as --frame LAS",
        path, space));
  } else {
    throw Error(
        fmt::format("{}: the NRRD header's space '{}' is unknown; kerf accepts left-posterior-superior (LPS), "
                    "right-anterior-superior (RAS) and left-anterior-superior (LAS), and others with --frame",
                    path, space));
  }
  return "LPS";
}

}  // namespace

void SetNrrdFrame(const ImageFields& fields, const std::string& path, const std::string& stated, Volume& volume) {
  volume.frame = stated.empty() ? FindFrame(fields, path, volume.warnings) : stated;
  ParseVectors(fields.Get("spaceorigin"), path);
  const bool has_directions = !ParseVectors(fields.Get("spacedirections"), path).empty();
  if ((fields.Contains("space") || fields.Contains("spacedimension")) && !has_directions) {
    throw Error(fmt::format(
        "{}: the NRRD header names a space but gives no 'space directions', so the orientation of the voxels in it is "
        "unknown",
        path));
  }
}

void PlaceNrrd(const ImageFields& fields, const std::string& path, Volume& volume) {
  std::vector<std::optional<Vec3>> directions = ParseVectors(fields.Get("spacedirections"), path);
  std::erase(directions, std::nullopt);  // axes that do not run through space
  const std::vector<double> spacings = ParseNumbers(fields.Get("spacings"));
  std::string units = fields.Get("spaceunits");
  glm::dmat3 steps(1);
  if (directions.size() >= 3) {
    for (int a = 0; a < 3; ++a) steps[a] = *directions[static_cast<std::size_t>(a)];
  } else if (spacings.size() >= 3) {
    for (int a = 0; a < 3; ++a) {
      const double spacing = spacings[static_cast<std::size_t>(a)];
      if (!(spacing > 0))
        throw Error(fmt::format("{}: the header's spacing is {}; it must be a length above 0", path, spacing));
      steps[a] *= spacing;
    }
    if (units.empty()) units = fields.Get("units");
  } else {
    throw Error(fmt::format(
        "{}: the NRRD header does not give the size of a voxel, neither by 'space directions' nor by 'spacings'",
        path));
  }
  const std::vector<std::optional<Vec3>> origin = ParseVectors(fields.Get("spaceorigin"), path);
  if (origin.empty() && fields.Contains("space")) {
    volume.warnings.emplace_back("the NRRD header has no space origin: the first voxel was taken to lie at 0, 0, 0");
  }
  PlaceLattice(origin.empty() ? Vec3(0) : origin[0].value_or(Vec3(0)), steps, UnitLength(ParseUnit(units, path), path),
               volume);
}

double CheckMetaSpacing(const ImageFields& fields, const std::string& path) {
  if (ParseNumbers(fields.Get("elementspacing")).size() < 3 && ParseNumbers(fields.Get("elementsize")).size() < 3) {
    throw Error(fmt::format(
        "{}: the MetaImage header does not give the size of a voxel, neither by ElementSpacing nor by ElementSize",
        path));
  }
  return UnitLength(fields.Get("distanceunits"), path);
}

}  // namespace kerf
