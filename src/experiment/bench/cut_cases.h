// The cuts with which the tick is measured.
#pragma once

#include "experiment/bench/cut_case.h"

namespace kerf {

/// Makes the bone of a cut a block, at the cut's pose, with the regions of the generic mandible.
void UseBlock(const Vec3& size_mm, double voxel_mm, CutCase& cut);
/// Returns a cut with the paper's saw 8 mm deep in a block that is rotated relative to the grid, so that disc, feed and
/// faces are all oblique to the voxels.
CutCase MakeDiscCut(double voxel_mm);
/// Returns all effects in the order of their calls, in which each follows those that it needs. The guide lies in the
/// plane of the cut, and the spindle is so strong that it keeps its speed: the cut stays the same.
EffectChoices ListEffectsOf(const CutCase& cut);
/// Returns the cut of MakeDiscCut(0.1) with all effects.
CutCase MakeEffectsCut();
/// Returns the same cut with 0.1 mm voxels, the coupling of a device and a trembling hand, which makes the flats touch
/// the walls of the kerf.
CutCase MakeHandCut();
/// Returns a cut in which the whole disc of the paper's saw starts inside the bone, so that as much of its rim and
/// flats as possible is in contact.
CutCase MakeBuriedCut();
/// Returns a cut with the disc that was used to measure iMSTK.
CutCase MakeThickDiscCut();
/// Returns the cut with which the other programs were measured: a ball of 3 mm radius, 2 mm deep. If `whole` is true,
/// it is made in their block of 256^3 voxels, otherwise in a bar of 50 mm x 10 mm x 7 mm.
CutCase MakeBallCut(double voxel_mm, double feed_mm_per_s, bool whole);
/// Returns a groove 4 mm deep that an upright bur with a point mills with its side and its end.
CutCase MakeBurCut(double voxel_mm);
/// Returns a hole that a twist drill makes along its axis.
CutCase MakeDrillCut(double voxel_mm);
/// Returns a slot that a blade with a stroke saws through a bar, feeding across its edge, which is longer than the bar
/// is wide. The case has the name of the blade's shape.
CutCase MakeSawnCut(const Tool& blade, double rpm, double bar_mm, double voxel_mm);
/// Returns a cut in which the saw moves up through the body of the generic mandible at the first molar. If `whole` is
/// true, the bone is the whole mandible, otherwise a block cut from it.
CutCase MakeMandibleCut(bool whole);

}  // namespace kerf
