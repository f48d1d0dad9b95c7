// The place of a structure that is nearest to the tool. Pure.
#pragma once

#include <optional>

#include "kerf/tool.h"
#include "view/live/overlays.h"

namespace kerf {

struct NearestPlace {
  Vec3 p_W{0};             // point of the structure
  double distance_mm = 0;  // from the tool; negative inside it
};

/// Returns the corner of a surface that is nearest to the tool: to a disc without its teeth, or to the ball. At most
/// half the length of an edge of the surface farther away than its nearest point. nullopt for an empty surface. Takes
/// 10 ns per corner.
std::optional<NearestPlace> FindNearest(const Tool& tool, const Pose& X_WT, const TriangleMesh& mesh_W);

/// Level for a distance from something that must not be cut: danger below 1 mm, a warning below 2 mm, a notice below
/// 4 mm.
AlarmLevel AlarmLevelFor(double distance_mm);

}  // namespace kerf
