// A bent arrow that shows the sense in which a tool turns. Pure.
#pragma once

#include "bone/mesh/meshfile.h"
#include "kerf/tool.h"

namespace kerf {

inline constexpr Rgb8 kTurnColour{213, 94, 0};

/// Makes an arrow with a round shaft along an arc about the z axis, in the plane z = 0. Its tip is at `to_rad`, before
/// or after `from_rad`.
TriangleMesh MakeTurnArrowMesh(double radius, double shaft_radius, double from_rad, double to_rad);

}  // namespace kerf
