// Section [plan] of a scene: planes and depth stops.
#pragma once

#include <string>
#include <vector>

#include "base/core/describe.h"
#include "base/toml/faults.h"
#include "base/toml/table_reader.h"
#include "session/plan/plan.h"
#include "session/scene/schema.h"

namespace kerf {

inline constexpr TextLimit kPlanNameLimit{60};
inline constexpr TextLimit kFileNameLimit{4096};

template <typename V>
void Describe(PlannedPlane& p, V&& visit) {
  visit("name", p.name, kPlanNameLimit, "unique name, used in reports; by default \"plane 1\", \"plane 2\" and so on");
  visit("point_mm", p.plane.p_W, kCoordinateRange_mm, "middle of the planned cut, on the plane");
  visit("normal", p.plane.normal_W, Range{-1000, 1000}, "normal of the plane, world frame; any length but 0");
  visit("margin_mm", p.margin_mm, Range{0.01, 100}, "distance from the plane within which the cut should stay");
}

template <typename V>
void Describe(DepthStop& p, V&& visit) {
  visit("name", p.name, kPlanNameLimit, "unique name, used in reports; by default \"stop 1\", \"stop 2\" and so on");
  visit("point_mm", p.p_W_mm, kCoordinateRange_mm, "point from which the depth is measured, world frame");
  visit("direction", p.direction_W, Range{-1000, 1000},
        "direction of the depth, into the bone, world frame; any length but 0");
  visit("depth_mm", p.depth_mm, Range{0, 1000}, "planned depth of the tool's deepest point beyond the point");
}

/// A file of 3D Slicer from which a plane is read.
struct PlanFile {
  std::size_t plane = 0;
  std::string file;   // absolute path
  std::string place;  // prefix of messages about it: "scene.toml:12:1: "
};

/// Reads [plan]. Planes from files are returned, to be read by ReadPlanFiles().
std::vector<PlanFile> ReadPlan(TableReader& root, Plan& plan, const std::string& scene_file, Faults& faults);
/// Sets the planes from the files. Throws kerf::Error with the place of the key.
void ReadPlanFiles(const std::vector<PlanFile>& files, Plan& plan);

}  // namespace kerf
