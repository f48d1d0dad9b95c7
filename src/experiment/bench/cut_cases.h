// The cuts with which the tick is measured.
#pragma once

#include "experiment/bench/cut_case.h"

namespace kerf {

/// The paper's saw 8 mm deep in a block that is rotated relative to the grid, so that disc, feed and faces are all
/// oblique to the voxels.
CutCase MakeDiscCut(double voxel_mm);
/// The same with 0.1 mm voxels, the coupling of a device and a trembling hand: the flats touch the walls of the kerf.
CutCase MakeHandCut();
/// The paper's saw, which starts with its whole disc inside the bone: the maximum contact of its rim and flats.
CutCase MakeBuriedCut();
/// The disc with which iMSTK was measured.
CutCase MakeThickDiscCut();
/// The cut used for the other programs: a ball of 3 mm radius, 2 mm deep. `whole`: in their block of 256^3 voxels,
/// otherwise in a bar cut from it.
CutCase MakeBallCut(double voxel_mm, double feed_mm_per_s, bool whole);
/// The saw moves up through the left body of the generic mandible below the first molar. `whole`: with the whole
/// mandible, otherwise with a block cut from it.
CutCase MakeMandibleCut(bool whole);

}  // namespace kerf
