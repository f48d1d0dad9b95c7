// Handpiece that holds a tool: plain solids for the picture, without influence on the simulation. Pure.
#pragma once

#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/tool.h"

namespace kerf {

/// Makes the neck and the handle as one closed surface in the tool's frame. The neck begins at the end of the spindle
/// (disc) or shank (ball) and follows the z axis; the handle leads through the grip and ends 25 mm behind it. A tool
/// whose grip is not on the side of the spindle has a straight handle. Throws Error for an invalid tool.
TriangleMesh MakeHandpieceMesh(const Tool& tool);

/// Returns points on the handpiece's surface in the tool's frame, at most about `step_mm` (above 0) apart along its
/// axis.
std::vector<Vec3> SampleHandpiece(const Tool& tool, double step_mm);

/// Returns a radius about the origin of the tool's frame that contains the handpiece, mm.
double CalcHandpieceReach(const Tool& tool);

}  // namespace kerf
