// Depth of the cut along the line of the wanted one.
#pragma once

#include <span>
#include <vector>

#include "bone/grid/removed.h"
#include "session/scene/exercise.h"
#include "session/score/columns.h"
#include "session/score/measures.h"

namespace kerf {

/// Returns depths of the cut below the surface, for columns of the line itself; 0: no cut there.
std::vector<double> MeasureDepths(const Bone& before, const Bone& after, const WantedCut& cut,
                                  std::span<const CutColumn> columns, std::span<const RemovedCell> cells);

/// Sets the sheet's measures of depth, for a cut that is not to go through the bone.
void MeasureLineDepths(const Bone& before, const Bone& after, const WantedCut& cut, std::span<const RemovedCell> cells,
                       ScoreSheet& sheet);

}  // namespace kerf
