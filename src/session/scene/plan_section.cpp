#include "session/scene/plan_section.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "base/core/printable.h"
#include "base/files/markups.h"
#include "kerf/error.h"
#include "session/scene/file_names.h"

namespace kerf {
namespace {

constexpr double kUnitNormalTolerance = 1e-9;

/// Normalises `v`; a vector of unit length is unchanged bit for bit.
void MakeUnit(TableReader& reader, const char* key, Vec3& v) {
  const double length = glm::length(v);
  if (!(length > 1e-6)) {
    reader.Fault(key, fmt::format("{} has no direction: its length is 0", key));
  } else if (std::abs(length - 1) > kUnitNormalTolerance) {
    v /= length;
  }
}

template <typename Item>
void CheckName(TableReader& reader, const std::vector<Item>& others, const std::string& name) {
  if (name.empty()) reader.Fault("name", "name is empty");
  for (const Item& other : others) {
    if (other.name == name) reader.Fault("name", fmt::format("the name \"{}\" is already taken", name));
  }
}

}  // namespace

std::vector<PlanFile> ReadPlan(TableReader& root, Plan& plan, const std::string& scene_file, Faults& faults) {
  std::vector<PlanFile> files;
  const TomlNode* table = root.Table("plan");
  if (table == nullptr) return files;
  TableReader reader(*table, "[plan]", faults);
  for (const TomlNode* item : reader.Tables("plane", kMaxPlanned)) {
    TableReader plane_reader(*item, "[[plan.plane]]", faults);
    PlannedPlane plane{.name = MakePlaneName(plan), .plane = {}, .margin_mm = 1};
    Describe(plane, plane_reader);
    if (plane_reader.Has("file")) {
      std::string file;
      ReadFileName(plane_reader, "file", file, scene_file);
      files.push_back({.plane = plan.planes.size(), .file = file, .place = item->PlaceOf("file", scene_file) + ": "});
      for (const char* key : {"point_mm", "normal"}) {
        if (plane_reader.Has(key)) plane_reader.Fault(key, fmt::format("{} and file specify the same; keep one", key));
      }
    } else {
      plane_reader.Require("point_mm");
      plane_reader.Require("normal");
      MakeUnit(plane_reader, "normal", plane.plane.normal_W);
    }
    if (plane_reader.Has("up")) MakeUnit(plane_reader, "up", plane.up_W);
    plane.name = Printable(plane.name);
    CheckName(plane_reader, plan.planes, plane.name);
    plane_reader.Finish();
    plan.planes.push_back(plane);
  }
  for (const TomlNode* item : reader.Tables("stop", kMaxPlanned)) {
    TableReader stop_reader(*item, "[[plan.stop]]", faults);
    DepthStop stop{.name = MakeStopName(plan), .p_W_mm = {}, .direction_W = {0, 0, -1}, .depth_mm = 5};
    Describe(stop, stop_reader);
    for (const char* key : {"point_mm", "direction", "depth_mm"}) stop_reader.Require(key);
    MakeUnit(stop_reader, "direction", stop.direction_W);
    stop.name = Printable(stop.name);
    CheckName(stop_reader, plan.stops, stop.name);
    stop_reader.Finish();
    plan.stops.push_back(stop);
  }
  reader.Finish();
  return files;
}

void ReadPlanFiles(const std::vector<PlanFile>& files, Plan& plan) {
  for (const PlanFile& file : files) {
    try {
      plan.planes[file.plane].plane = ReadPlaneMarkups(file.file);
    } catch (const Error& e) {
      throw Error(file.place + e.what());
    }
  }
}

}  // namespace kerf
