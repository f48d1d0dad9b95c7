// Measures of drilled holes.
#pragma once

#include <optional>
#include <vector>

#include "kerf/bone.h"
#include "kerf/geometry.h"
#include "session/scene/exercise.h"
#include "session/score/measures.h"

namespace kerf {

/// Sets the sheet's measures of holes. `deepest`: MotionMeter::FindDeepest().
void MeasureHoles(const Bone& before, const std::vector<WantedCut>& holes,
                  const std::vector<std::optional<Pose>>& deepest, ScoreSheet& sheet);

}  // namespace kerf
