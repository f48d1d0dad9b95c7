// Compares the cut with the wanted cut, using only the bone before and after.
#pragma once

#include <vector>

#include "kerf/bone.h"
#include "session/scene/exercise.h"
#include "session/score/measures.h"

namespace kerf {

/// Sets the sheet's measures that need no recording: volumes, planes, depths. `cuts`: empty if nothing was planned. Of
/// several cuts, the sheet has the sums of the volumes, and the largest errors.
void MeasureCut(const Bone& before, const Bone& after, const std::vector<WantedCut>& cuts, ScoreSheet& sheet);

}  // namespace kerf
