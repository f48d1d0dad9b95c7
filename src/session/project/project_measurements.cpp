#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <set>

#include "base/core/printable.h"
#include "base/files/json_text.h"
#include "kerf/error.h"
#include "kerf/geometry.h"
#include "session/project/members.h"
#include "session/project/project.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

PiecePoint ParsePoint(const Json& entry, const std::string& path) {
  const Json piece = entry.is_object() ? entry.value("piece", Json()) : Json();
  if (!piece.is_string()) throw Error(fmt::format("{}: a point of a measurement does not name its piece", path));
  PiecePoint point{.piece = piece.get<std::string>()};
  const Json position = entry.value("position_mm", Json());
  bool valid = position.is_array() && position.size() == 3;
  for (int a = 0; valid && a < 3; ++a) {
    const Json& number = position[static_cast<std::size_t>(a)];
    valid = number.is_number();
    if (valid) point.p_P[a] = number.get<double>();
  }
  if (!valid || !IsInWorld(point.p_P)) {
    throw Error(fmt::format("{}: 'position_mm' of a measurement is not a list of three valid numbers", path));
  }
  return point;
}

/// Returns the names of the pieces in a pieces.json. Whether it is valid is known once the bone is split.
std::set<std::string> ListPieces(const std::string& pieces_json, const std::string& path) {
  std::set<std::string> names;
  const Json json = pieces_json.empty() ? Json() : ParseJson(pieces_json, path);
  const Json pieces = json.is_object() ? json.value("pieces", Json()) : Json();
  if (!pieces.is_array()) return names;
  for (const Json& entry : pieces) {
    const Json name = entry.is_object() ? entry.value("name", Json()) : Json();
    if (name.is_string()) names.insert(name.get<std::string>());
  }
  return names;
}

}  // namespace

std::string FormatMeasuredPoints(const std::vector<MeasuredPoints>& measurements) {
  OrderedJson json = OrderedJson::array();
  for (const MeasuredPoints& measurement : measurements) {
    OrderedJson points = OrderedJson::array();
    for (const PiecePoint& point : measurement) {
      points.push_back({{"piece", point.piece}, {"position_mm", {point.p_P.x, point.p_P.y, point.p_P.z}}});
    }
    json.push_back({{"points", std::move(points)}});
  }
  return json.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::vector<MeasuredPoints> ParseMeasuredPoints(const std::string& text, const std::string& path) {
  const Json json = ParseJson(text, path);
  if (!json.is_array()) throw Error(fmt::format("{}: the measurements are not a list", path));
  std::vector<MeasuredPoints> measurements;
  for (const Json& entry : json) {
    const Json points = entry.is_object() ? entry.value("points", Json()) : Json();
    if (!points.is_array()) throw Error(fmt::format("{}: a measurement has no list 'points'", path));
    MeasuredPoints measurement;
    for (const Json& point : points) measurement.push_back(ParsePoint(point, path));
    measurements.push_back(std::move(measurement));
  }
  return measurements;
}

void CheckMeasuredPoints(const std::vector<MeasuredPoints>& measurements, const std::string& pieces_json,
                         const std::string& path) {
  if (measurements.size() > project_detail::kMaxMeasurements) {
    throw Error(fmt::format("{}: a project has at most {} measurements", path, project_detail::kMaxMeasurements));
  }
  if (measurements.empty()) return;
  const std::set<std::string> pieces = ListPieces(pieces_json, fmt::format("{}: {}", path, project_detail::kPieces));
  for (const MeasuredPoints& measurement : measurements) {
    if (measurement.size() != 2 && measurement.size() != 3) {
      throw Error(fmt::format("{}: a measurement has neither 2 points (a distance) nor 3 (an angle)", path));
    }
    for (const PiecePoint& point : measurement) {
      if (pieces.count(point.piece) != 0) continue;
      throw Error(fmt::format("{}: a measurement names '{}', which is not a piece of the project", path,
                              Printable(point.piece.substr(0, 200))));
    }
  }
}

}  // namespace kerf
