// A place for the saw that the user sees.
#pragma once

#include "bone/grid/removed.h"
#include "kerf/tool.h"
#include "view/live/viewport.h"

namespace kerf {

/// Returns `X_home` if the tool is seen there: a good part of it is within `area` of the picture, and its middle is not
/// behind the bone.
/// Otherwise the pose with the same orientation in front of the bone, in the middle of the area; it may touch the bone
/// if the view is too near for another place. `bounds_W`: of the bone.
Pose FindSeenPose(const ViewCamera& camera, const ScreenBox& area, const PhiSampler& bone, const Box3& bounds_W,
                  const Tool& tool, const Pose& X_home);

}  // namespace kerf
