// Pose of a tool that replaces another one at the same place of the bone.
#pragma once

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Returns the pose in which `to` has its edge where `from` has it in the pose `X_WF`: the point that lies furthest in
/// the direction into the bone. That is the direction of a disc's rim where it is nearest to the bone, the feed of a
/// blade with a stroke, and the axis of any other tool. A tool of the same form keeps its orientation; otherwise the
/// direction into the bone stays the same, and the plane of a blade. If bone is in the way, the tool is moved to the
/// nearest place that is clear of it.
Pose KeepEdge(const Bone& bone, const Tool& from, const Pose& X_WF, const Tool& to);

}  // namespace kerf
