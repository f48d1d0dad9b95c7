// Alarm of the nerve canal of a bone's own regions.
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

}  // namespace kerf
