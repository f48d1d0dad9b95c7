// The section [plan] of a scene: planes and depth stops.
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

template <typename V>
void Describe(PlannedPlane& p, V&& visit) {
  visit("name", p.name, kPlanNameLimit,
        "for people, and for reports; its own; \"plane 1\" and so on where it is left out");
  visit("point_mm", p.plane.p_W, kCoordinateRange_mm, "middle of the cut that is meant, on the plane");
  visit("normal", p.plane.normal_W, Range{-1000, 1000}, "of the plane, world frame; any length but 0");
  visit("margin_mm", p.margin_mm, Range{0.01, 100}, "the cut should stay so near to the plane");
}

template <typename V>
void Describe(DepthStop& p, V&& visit) {
  visit("name", p.name, kPlanNameLimit,
        "for people, and for reports; its own; \"stop 1\" and so on where it is left out");
  visit("point_mm", p.p_W_mm, kCoordinateRange_mm, "from which the depth counts");
  visit("direction", p.direction_W, Range{-1000, 1000}, "into the bone, world frame; any length but 0");
  visit("depth_mm", p.depth_mm, Range{0, 1000},
        "so far past the point the tool's deepest point should go, and no further");
}

/// A file of 3D Slicer that a plane is to be read from.
struct PlanFile {
  std::size_t plane = 0;
  std::string file;   // absolute path
  std::string place;  // in front of a message about it: "scene.toml:12:1: "
};

/// Reads [plan]; planes of files are left for ReadPlanFiles().
std::vector<PlanFile> ReadPlan(TableReader& root, Plan& plan, const std::string& scene_file, Faults& faults);
/// From here on the scene has what the files say. Throws Error at the key.
void ReadPlanFiles(const std::vector<PlanFile>& files, Plan& plan);

}  // namespace kerf
