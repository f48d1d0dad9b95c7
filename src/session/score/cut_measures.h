// Compares the cut with the wanted cut, using the bone before and after and, of a bur, how it leaned.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "kerf/bone.h"
#include "session/scene/exercise.h"
#include "session/score/measures.h"

namespace kerf {

/// Sets the sheet's measures of volumes, planes and depths. `cuts`: empty if nothing was planned. `leans_deg`: one for
/// each cut, from MotionMeter::FindLeans_deg(); empty: not known. Of several cuts, the sheet has the sums of the
/// volumes, and the largest errors.
void MeasureCut(const Bone& before, const Bone& after, const std::vector<WantedCut>& cuts,
                std::span<const std::optional<double>> leans_deg, ScoreSheet& sheet);

}  // namespace kerf
