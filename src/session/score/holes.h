// Measures of drilled holes.
#pragma once

#include <optional>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "session/scene/exercise.h"
#include "session/score/columns.h"
#include "session/score/measures.h"

namespace kerf {

/// Returns how the hole was drilled whose deepest pose of the drill is `X_WT`; none: it was not begun, so the drill's
/// axis points against the hole or meets no bone above the tip. `before`: the bone before the cut.
std::optional<HoleResult> MeasureHole(const PhiSampler& before, const WantedCut& hole, const Pose& X_WT);

/// Sets the sheet's measures of holes. `deepest`: MotionMeter::FindDeepest().
void MeasureHoles(const Bone& before, const std::vector<WantedCut>& holes,
                  const std::vector<std::optional<Pose>>& deepest, ScoreSheet& sheet);

}  // namespace kerf
