#include "import/markups.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "files/files.h"
#include "kerf/error.h"

namespace kerf {

std::vector<Vec3> ReadMarkups(const std::string& path) {
  using Json = nlohmann::json;
  Json file;
  try {
    file = Json::parse(ReadTextFile(path));
  } catch (const Json::exception& e) {
    throw Error(fmt::format("{}: not valid JSON ({})", path, e.what()));
  }
  const auto markups = file.is_object() ? file.find("markups") : file.end();
  if (!file.is_object() || markups == file.end() || !markups->is_array()) {
    throw Error(fmt::format("{}: not a markups file of 3D Slicer (it has no list 'markups')", path));
  }
  std::vector<Vec3> points;
  for (const Json& markup : *markups) {
    if (!markup.is_object()) throw Error(fmt::format("{}: an entry of 'markups' is no object", path));
    const std::string system = markup.contains("coordinateSystem") && markup["coordinateSystem"].is_string()
                                   ? markup["coordinateSystem"].get<std::string>()
                                   : std::string();
    double flip = 0;
    if (system == "LPS" || system == "0") flip = 1;
    if (system == "RAS" || system == "1") flip = -1;
    if (flip == 0) throw Error(fmt::format("{}: coordinateSystem is '{}'; it must be LPS or RAS", path, system));
    if (markup.contains("coordinateUnits") && markup["coordinateUnits"].is_string()) {
      const auto units = markup["coordinateUnits"].get<std::string>();
      if (units != "mm" && units.rfind("[\"mm\"", 0) != 0) {
        throw Error(fmt::format("{}: coordinateUnits is '{}'; it must be mm", path, units));
      }
    }
    if (!markup.contains("controlPoints") || !markup["controlPoints"].is_array()) continue;
    for (const Json& point : markup["controlPoints"]) {
      if (!point.is_object()) throw Error(fmt::format("{}: a control point is no object", path));
      if (point.contains("positionStatus") && point["positionStatus"].is_string() &&
          point["positionStatus"] != "defined")
        continue;
      const auto position = point.find("position");
      if (position == point.end() || !position->is_array() || position->size() != 3) {
        throw Error(fmt::format("{}: control point {} has no position of three numbers", path, points.size() + 1));
      }
      Vec3 p;
      for (int a = 0; a < 3; ++a) {
        const Json& number = (*position)[static_cast<std::size_t>(a)];
        p[a] = number.is_number() ? number.get<double>() : std::nan("");
        if (!std::isfinite(p[a]))
          throw Error(fmt::format("{}: control point {} has a coordinate that is no number", path, points.size() + 1));
      }
      points.emplace_back(flip * p.x, flip * p.y, p.z);
    }
  }
  if (points.empty()) throw Error(fmt::format("{}: holds no placed control point", path));
  return points;
}

}  // namespace kerf
