// The cuts that the tick is measured on.
#pragma once

#include "experiment/bench/cut_case.h"

namespace kerf {

/// The saw of the paper 8 mm deep in a block that stands askew in the grid, so that disc, feed and faces are all tilted
/// against the voxels.
CutCase MakeDiscCut(double voxel_mm);
/// The same at 0.1 mm, held as a device holds it, by a hand that trembles: the faces meet the walls of the kerf.
CutCase MakeHandCut();
/// The saw of the paper with all of its disc inside the bone, where it began: the most that its rim and flats can meet.
CutCase MakeBuriedCut();
/// The disc that iMSTK was measured with.
CutCase MakeThickDiscCut();
/// The peers' cut: a ball of 3 mm radius, 2 mm deep. `whole`: in their block of 256^3 voxels, else in a bar of it.
CutCase MakeBallCut(double voxel_mm, double feed_mm_per_s, bool whole);
/// The saw goes up through the left body of the generic mandible below the first molar. `whole`: with all of the
/// mandible about it, else with a block of it.
CutCase MakeMandibleCut(bool whole);

}  // namespace kerf
