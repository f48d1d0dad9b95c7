// Handpiece that holds a tool, as a surface: cut/tool/handpiece.h gives its shape. Pure.
#pragma once

#include <vector>

#include "bone/mesh/meshfile.h"
#include "kerf/tool.h"

namespace kerf {

/// Makes neck and handle (MakeHandpiece()) as one closed surface in the tool's frame. Throws Error for an invalid tool.
TriangleMesh MakeHandpieceMesh(const Tool& tool);

/// Returns points on the handpiece's surface in the tool's frame, at most about `step_mm` (above 0) apart along its
/// axis.
std::vector<Vec3> SampleHandpiece(const Tool& tool, double step_mm);

/// Returns a radius about the origin of the tool's frame that contains the handpiece, mm.
double CalcHandpieceReach(const Tool& tool);

}  // namespace kerf
