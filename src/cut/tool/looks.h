// What a tool looks like: surfaces and lines in the tool frame T, without influence on the simulation.
#pragma once

#include <optional>
#include <vector>

#include "kerf/tool.h"

namespace kerf {

/// Ring in which the teeth of a turning tool are seen only as a blur.
struct ToolBlur {
  double from_mm, to_mm;     // distance from the spindle axis: floor of the gullets, tips of the teeth
  double half_thickness_mm;  // of the blade
};

/// Parts of a tool, tool frame, mm. Those that a kind of tool does not have are empty.
struct ToolLooks {
  TriangleMesh whole;            // closed surfaces: the tool with its teeth or flutes, and the end of the spindle
  TriangleMesh turning;          // the same without teeth, for a spindle that is too fast to see them
  std::optional<ToolBlur> blur;  // with `turning`
  TriangleMesh guard;            // closed surface: a cover over the rim, on the side away from the cut (-x)
  std::vector<Vec3> hub;         // points around the outer faces of the hub that clamps a blade
  std::vector<Vec3> outline;     // corners of the closed line around a blade, in the plane z = 0
};
/// Throws kerf::Error for an invalid tool.
ToolLooks MakeToolLooks(const Tool& tool);

/// Returns the outline of the section of a tool with the plane z = 0 of a frame S, in S: a closed polyline, whose last
/// point is the first one again; empty if they do not meet. `least_mm`: a thinner blade is drawn with this thickness.
std::vector<Vec3> MakeToolSection(const Tool& tool, const Pose& X_ST, double least_mm);

/// Returns the same of all that a blade passes in a whole stroke, for the tool in the middle of it; empty for a tool
/// that turns.
std::vector<Vec3> MakeStrokeSection(const Tool& tool, const Pose& X_ST, double least_mm);

/// Returns where a tool is thought to touch what lies in a direction, tool frame: the point of the edge that is
/// furthest along it, or the middle of a straight edge.
Vec3 FindForemost(const Tool& tool, const Vec3& n_T);

}  // namespace kerf
