#include "base/files/markups.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <set>

#include "base/core/foreign_format.h"
#include "base/core/symmetric_eigen.h"
#include "base/files/files.h"
#include "base/files/json_text.h"
#include "base/files/limits.h"
#include "kerf/error.h"

namespace kerf {
namespace {

using Json = nlohmann::json;

constexpr std::size_t kMaxQuotedBytes = 60;  // of a file's text in a message

/// Returns the list of markups; each is an object.
Json ParseMarkupList(const std::string& text, const std::string& path) {
  const Json file = ParseJson(text, path);
  const auto markups = file.is_object() ? file.find("markups") : file.end();
  if (!file.is_object() || markups == file.end() || !markups->is_array()) {
    throw Error(fmt::format("{}: not a 3D Slicer markups file (it has no list 'markups')", path));
  }
  for (const Json& markup : *markups) {
    if (!markup.is_object()) throw Error(fmt::format("{}: an entry of 'markups' is not an object", path));
  }
  return *markups;
}

/// Returns the factor, 1 or -1, that converts x and y of the markup's coordinate system to LPS.
double CalcFlip(const Json& markup, const std::string& path) {
  const bool given = markup.contains("coordinateSystem");
  const std::string system = given && markup["coordinateSystem"].is_string()
                                 ? fmt::format("'{}'", markup["coordinateSystem"].get<std::string>())
                             : given ? markup["coordinateSystem"].dump()
                                     : "missing";
  double flip = 0;
  if (system == "'LPS'") flip = 1;
  if (system == "'RAS'") flip = -1;
  if (flip == 0) throw Error(fmt::format("{}: coordinateSystem is {}; it must be LPS or RAS", path, system));
  if (markup.contains("coordinateUnits") && markup["coordinateUnits"].is_string()) {
    const auto units = markup["coordinateUnits"].get<std::string>();
    if (units != "mm" && units.rfind("[\"mm\"", 0) != 0) {
      throw Error(fmt::format("{}: coordinateUnits is '{}'; it must be mm", path, units));
    }
  }
  return flip;
}

/// Adds the markup's placed control points.
void AddPoints(const Json& markup, const std::string& path, std::vector<Vec3>& points) {
  const double flip = CalcFlip(markup, path);
  if (!markup.contains("controlPoints") || !markup["controlPoints"].is_array()) return;
  for (const Json& point : markup["controlPoints"]) {
    if (!point.is_object()) throw Error(fmt::format("{}: a control point is not an object", path));
    if (point.contains("positionStatus") && point["positionStatus"].is_string() &&
        point["positionStatus"] != "defined") {
      continue;
    }
    const auto position = point.find("position");
    if (position == point.end() || !position->is_array() || position->size() != 3) {
      throw Error(fmt::format("{}: control point {} has no position with three coordinates{}", path, points.size() + 1,
                              position != point.end() && position->is_array() && position->size() == 6
                                  ? "; if they have decimal commas, write decimal points"
                                  : ""));
    }
    Vec3 p;
    for (int a = 0; a < 3; ++a) {
      const Json& number = (*position)[static_cast<std::size_t>(a)];
      p[a] = number.is_number() ? number.get<double>() : std::nan("");
      if (!std::isfinite(p[a])) {
        throw Error(fmt::format("{}: control point {} has a coordinate that is not a number{}", path, points.size() + 1,
                                number.is_string() ? DescribeForeignNumber(number.get<std::string>()) : ""));
      }
    }
    points.emplace_back(flip * p.x, flip * p.y, p.z);
  }
}

/// Returns a list of `count` numbers from a markup; nullopt if the key is missing.
std::optional<std::vector<double>> FindNumbers(const Json& markup, const char* key, std::size_t count,
                                               const std::string& path) {
  const auto found = markup.find(key);
  if (found == markup.end()) return {};
  std::vector<double> numbers;
  if (found->is_array()) {
    for (const Json& number : *found) {
      if (number.is_number() && std::isfinite(number.get<double>())) numbers.push_back(number.get<double>());
    }
  }
  if (!found->is_array() || numbers.size() != count || found->size() != count) {
    throw Error(fmt::format("{}: '{}' of the plane is not a list of {} numbers", path, key, count));
  }
  return numbers;
}

Vec3 Normalized(const Vec3& v, const char* key, const std::string& path) {
  const std::optional<Vec3> direction = CalcDirection(v);
  if (!direction) throw Error(fmt::format("{}: '{}' of the plane has no direction", path, key));
  return *direction;
}

/// Returns the normal according to the matrices: the z axis of the object's frame in the file's frame. Slicer converts
/// LPS files to its own RAS by negating the upper two rows of both matrices.
std::optional<Vec3> FindMatrixNormal(const Json& plane, bool lps, const std::string& path) {
  const auto base = FindNumbers(plane, "baseToNode", 16, path);
  if (!base) return {};
  Vec3 z(0, 0, 1);
  if (const auto object = FindNumbers(plane, "objectToBase", 16, path)) {
    const double flip = lps ? -1 : 1;
    z = {flip * (*object)[2], flip * (*object)[6], (*object)[10]};
  }
  const auto& m = *base;
  const Vec3 normal(m[0] * z.x + m[1] * z.y + m[2] * z.z, m[4] * z.x + m[5] * z.y + m[6] * z.z,
                    m[8] * z.x + m[9] * z.y + m[10] * z.z);
  return Normalized(normal, "baseToNode", path);
}

CutPlane ReadPlane(const Json& plane, const std::string& path) {
  const double flip = CalcFlip(plane, path);
  const auto to_lps = [flip](const Vec3& v) { return Vec3(flip * v.x, flip * v.y, v.z); };
  std::vector<Vec3> points;
  AddPoints(plane, path, points);
  const auto centre = FindNumbers(plane, "center", 3, path);
  const auto normal = FindNumbers(plane, "normal", 3, path);
  const auto from_matrix = FindMatrixNormal(plane, flip > 0, path);
  if (!normal && !from_matrix) return FitPlane(points, path);
  if (!centre && points.empty())
    throw Error(fmt::format("{}: the plane has neither a center nor a placed point", path));
  CutPlane cut;
  cut.normal_W = to_lps(normal ? Normalized({(*normal)[0], (*normal)[1], (*normal)[2]}, "normal", path) : *from_matrix);
  cut.p_W = centre ? to_lps({(*centre)[0], (*centre)[1], (*centre)[2]}) : points.front();
  // Slicer displays the matrix and the points. A file edited by a user may contain contradictory values.
  const bool same_normal = !normal || !from_matrix || glm::length(cut.normal_W - to_lps(*from_matrix)) < 1e-3;
  const bool one_point = plane.value("planeType", Json()) == "pointNormal" && points.size() == 1;
  const bool same_point = !one_point || std::abs(glm::dot(cut.normal_W, points[0] - cut.p_W)) < 0.01;
  if (!same_normal || !same_point) {
    throw Error(fmt::format("{}: the plane's {} contradict each other; save it again from 3D Slicer", path,
                            same_normal ? "'center' and its control point" : "'normal' and 'baseToNode'"));
  }
  return cut;
}

}  // namespace

CutPlane FitPlane(const std::vector<Vec3>& points, const std::string& what) {
  if (points.size() < 3) {
    throw Error(fmt::format("{}: contains {} placed point{}; a plane needs three", what, points.size(),
                            points.size() == 1 ? "" : "s"));
  }
  const auto [mean, eigen] = CalcPointSpread(points);
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&values = eigen.values](std::size_t i, std::size_t j) { return values[i] < values[j]; });
  // Compares the smaller spread within the plane with the larger.
  if (!(eigen.values[order[1]] > 1e-6 * eigen.values[order[2]])) {
    throw Error(fmt::format("{}: its points lie on a line, so they do not define a plane", what));
  }
  const Vec3 normal = glm::normalize(eigen.vectors[order[0]]);
  const double turn = glm::dot(normal, glm::cross(points[1] - points[0], points[2] - points[0]));
  return {mean, turn < 0 ? -normal : normal};
}

std::vector<Vec3> ParseMarkups(const std::string& text, const std::string& path) {
  std::vector<Vec3> points;
  for (const Json& markup : ParseMarkupList(text, path)) AddPoints(markup, path, points);
  if (points.empty()) throw Error(fmt::format("{}: contains no placed control point", path));
  return points;
}

std::vector<Markup> ParseCurveMarkups(const std::string& text, const std::string& path) {
  std::vector<Markup> markups;
  for (const Json& json : ParseMarkupList(text, path)) {
    const auto type = json.find("type");
    const std::string word = type != json.end() && type->is_string() ? type->get<std::string>() : "";
    Markup markup;
    markup.joined = word == "Curve" || word == "ClosedCurve" || word == "Line";
    if (!markup.joined && word != "Fiducial" && word != "PointList") {
      throw Error(fmt::format("{}: contains a markup of type '{}'; it must be Curve, ClosedCurve, Line or Fiducial",
                              path, word));
    }
    AddPoints(json, path, markup.points);
    if (markup.points.empty()) continue;
    if (word == "ClosedCurve" && markup.points.size() > 2) markup.points.push_back(markup.points.front());
    markups.push_back(std::move(markup));
  }
  if (markups.empty()) throw Error(fmt::format("{}: contains no placed control point", path));
  return markups;
}

CutPlane ParsePlaneMarkups(const std::string& text, const std::string& path) {
  const Json markups = ParseMarkupList(text, path);
  std::vector<Vec3> points;
  const Json* plane = nullptr;
  for (const Json& markup : markups) {
    const auto type = markup.find("type");
    if (type != markup.end() && *type == "Plane") {
      if (plane) throw Error(fmt::format("{}: contains several planes; save only the intended one", path));
      plane = &markup;
    } else {
      AddPoints(markup, path, points);
    }
  }
  return plane ? ReadPlane(*plane, path) : FitPlane(points, path);
}

std::vector<TubeMarkup> ParseTubeMarkups(const std::string& text, const std::string& path) {
  std::vector<TubeMarkup> curves;
  std::set<std::string> taken;
  for (const Json& json : ParseMarkupList(text, path)) {
    const Json type = json.value("type", Json());
    const std::string word = type.is_string() ? type.get<std::string>() : "";
    if (word != "Curve" && word != "ClosedCurve" && word != "Line") {
      throw Error(fmt::format("{}: contains a markup of type '{}'; it must be Curve, ClosedCurve or Line", path,
                              word.substr(0, kMaxQuotedBytes)));
    }
    TubeMarkup curve;
    AddPoints(json, path, curve.points);
    if (curve.points.empty()) continue;
    if (word == "ClosedCurve" && curve.points.size() > 2) curve.points.push_back(curve.points.front());
    const Json name = json.value("name", Json());
    const std::string given = name.is_string() && !name.get<std::string>().empty()
                                  ? name.get<std::string>()
                                  : fmt::format("curve {}", curves.size() + 1);
    curve.name = given;
    for (int again = 2; !taken.insert(curve.name).second; ++again) curve.name = fmt::format("{} {}", given, again);
    if (const auto radius = json.find("radius"); radius != json.end()) {
      const double radius_mm = radius->is_number() ? radius->get<double>() : std::nan("");
      if (!(radius_mm > 0) || !std::isfinite(radius_mm)) {
        throw Error(fmt::format("{}: 'radius' of the curve '{}' is not a positive number", path,
                                curve.name.substr(0, kMaxQuotedBytes)));
      }
      curve.radius_mm = radius_mm;
    }
    if (const auto kind = json.find("kind"); kind != json.end()) {
      if (!kind->is_string()) {
        throw Error(
            fmt::format("{}: 'kind' of the curve '{}' is not a word", path, curve.name.substr(0, kMaxQuotedBytes)));
      }
      curve.kind = kind->get<std::string>();
    }
    curves.push_back(std::move(curve));
  }
  if (curves.empty()) throw Error(fmt::format("{}: contains no placed control point", path));
  return curves;
}

std::vector<PlaneMarkup> ParsePlanes(const std::string& text, const std::string& path) {
  std::vector<PlaneMarkup> planes;
  for (const Json& markup : ParseMarkupList(text, path)) {
    if (markup.value("type", Json()) != "Plane") continue;
    const Json name = markup.value("name", Json());
    planes.push_back({.name = name.is_string() ? name.get<std::string>() : "", .plane = ReadPlane(markup, path)});
  }
  return planes;
}

std::vector<PlaneMarkup> ParsePlaneMarkupList(const std::string& text, const std::string& path) {
  std::vector<PlaneMarkup> planes = ParsePlanes(text, path);
  if (planes.empty()) {
    std::vector<Vec3> points;
    for (const Json& markup : ParseMarkupList(text, path)) AddPoints(markup, path, points);
    planes.push_back({.name = "", .plane = FitPlane(points, path)});
  }
  std::set<std::string> taken;
  for (std::size_t i = 0; i < planes.size(); ++i) {
    const std::string given = planes[i].name.empty() ? fmt::format("plane {}", i + 1) : planes[i].name;
    planes[i].name = given;
    for (int again = 2; !taken.insert(planes[i].name).second; ++again) {
      planes[i].name = fmt::format("{} {}", given, again);
    }
  }
  return planes;
}

std::vector<PlaneMarkup> ReadPlaneMarkupList(const std::string& path) {
  return ParsePlaneMarkupList(ReadTextFile(path, kMaxMarkupBytes), path);
}

std::vector<Vec3> ReadMarkups(const std::string& path) {
  return ParseMarkups(ReadTextFile(path, kMaxMarkupBytes), path);
}

std::vector<Markup> ReadCurveMarkups(const std::string& path) {
  return ParseCurveMarkups(ReadTextFile(path, kMaxMarkupBytes), path);
}

CutPlane ReadPlaneMarkups(const std::string& path) {
  return ParsePlaneMarkups(ReadTextFile(path, kMaxMarkupBytes), path);
}

}  // namespace kerf
