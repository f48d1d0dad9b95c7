// Alarms of the nerve canal and the teeth of a bone's own regions.
#pragma once

#include <optional>

#include "app/window/shown_bone.h"
#include "session/score/region_distance.h"
#include "view/live/overlays.h"

namespace kerf {

/// Returns the alarm at the place of the canal that is nearest to the saw. It shows the same distance as the values in
/// the left column (`nerve`); until that is available (null), the distance to the surface as it is drawn. None if the
/// bone has no canal.
std::optional<AlarmOverlay> MakeNerveAlarm(const ShownBone& bone, const RegionDistance* nerve, const Tool& tool,
                                           const Pose& X_WT);

/// Returns the alarm of the teeth for a saw that cuts: the place that is nearest to it. `teeth_W`: their surface as it
/// is drawn; `cuts`: the saw cuts a tooth now. Otherwise, it is a notice near a tooth. None if there is nothing to say.
std::optional<AlarmOverlay> MakeToothAlarm(const TriangleMesh& teeth_W, bool cuts, const Tool& tool, const Pose& X_WT);

}  // namespace kerf
