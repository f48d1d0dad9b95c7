#include <cmath>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include "base/files/files.h"
#include "base/files/markups.h"

namespace kerf {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kSchema =
    "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
    "markups-schema-v1.0.3.json#";

OrderedJson List(const Vec3& v) {
  return OrderedJson::array({v.x, v.y, v.z});
}

OrderedJson MakePlane(const PlaneMarkup& markup, double size_mm) {
  const Vec3& n = markup.plane.normal_W;
  const Vec3& p = markup.plane.p_W;
  const Vec3 other = std::abs(n.x) < 0.7 ? Vec3(1, 0, 0) : Vec3(0, 1, 0);
  const Vec3 u = glm::normalize(other - glm::dot(other, n) * n);
  const Vec3 v = glm::cross(n, u);
  const double half = 0.5 * size_mm;
  OrderedJson plane{
      {"type", "Plane"},
      {"name", markup.name},
      {"coordinateSystem", "LPS"},
      {"coordinateUnits", "mm"},
      {"locked", false},
      {"fixedNumberOfControlPoints", true},
      {"labelFormat", "%N"},
      {"lastUsedControlPointNumber", 1},
      {"planeType", "pointNormal"},
      {"sizeMode", "absolute"},
      {"autoScalingSizeFactor", 1.0},
      {"center", List(p)},
      {"normal", List(n)},
      // Identity matrix as written in an LPS file.
      {"objectToBase", {-1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0}},
      {"baseToNode", {u.x, v.x, n.x, p.x, u.y, v.y, n.y, p.y, u.z, v.z, n.z, p.z, 0.0, 0.0, 0.0, 1.0}},
      {"orientation", {u.x, v.x, n.x, u.y, v.y, n.y, u.z, v.z, n.z}},
      {"size", {size_mm, size_mm, 0.0}},
      {"planeBounds", {-half, half, -half, half}}};
  plane["controlPoints"] = OrderedJson::array();
  plane["controlPoints"].push_back({{"id", "1"},
                                    {"label", markup.name},
                                    {"description", ""},
                                    {"associatedNodeID", ""},
                                    {"position", List(p)},
                                    {"orientation", {-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0}},
                                    {"selected", true},
                                    {"locked", false},
                                    {"visibility", true},
                                    {"positionStatus", "defined"}});
  plane["measurements"] = OrderedJson::array();
  return plane;
}

OrderedJson MakeCurve(const TubeMarkup& markup) {
  OrderedJson curve{{"type", "Curve"},           {"name", markup.name},
                    {"coordinateSystem", "LPS"}, {"coordinateUnits", "mm"},
                    {"locked", false},           {"fixedNumberOfControlPoints", false},
                    {"labelFormat", "%N-%d"},    {"lastUsedControlPointNumber", markup.points.size()}};
  if (markup.radius_mm) curve["radius"] = *markup.radius_mm;
  if (!markup.kind.empty()) curve["kind"] = markup.kind;
  curve["controlPoints"] = OrderedJson::array();
  for (std::size_t i = 0; i < markup.points.size(); ++i) {
    curve["controlPoints"].push_back({{"id", std::to_string(i + 1)},
                                      {"label", markup.name + "-" + std::to_string(i + 1)},
                                      {"description", ""},
                                      {"associatedNodeID", ""},
                                      {"position", List(markup.points[i])},
                                      {"orientation", {-1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, 1.0}},
                                      {"selected", true},
                                      {"locked", false},
                                      {"visibility", true},
                                      {"positionStatus", "defined"}});
  }
  curve["measurements"] = OrderedJson::array();
  return curve;
}

}  // namespace

std::string FormatTubeMarkups(const std::vector<TubeMarkup>& curves) {
  OrderedJson file{{"@schema", kSchema}};
  file["markups"] = OrderedJson::array();
  for (const TubeMarkup& curve : curves) file["markups"].push_back(MakeCurve(curve));
  return file.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::string FormatPlaneMarkups(const std::vector<PlaneMarkup>& planes, double size_mm) {
  OrderedJson file{{"@schema", kSchema}};
  file["markups"] = OrderedJson::array();
  for (const PlaneMarkup& plane : planes) file["markups"].push_back(MakePlane(plane, size_mm));
  return file.dump(2, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

void WritePlaneMarkups(const std::string& path, const std::vector<PlaneMarkup>& planes, double size_mm) {
  WriteTextFile(path, FormatPlaneMarkups(planes, size_mm));
}

}  // namespace kerf
