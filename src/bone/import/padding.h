// Padding: what a scan's image contains where there is no scan, such as outside the scanner's circle.
#pragma once

#include "bone/import/volume.h"

namespace kerf {

/// Makes padding air, -1024 HU, marks it in Volume::padding, and adds a warning to the volume's: a value below that of
/// air by more than 175 HU that is the lowest and has at least a thousandth of the voxels, with all others below air by
/// that much; any value below -4000 HU; and one value of 1000 HU or more that fills three edges of the scan along one
/// axis and is brighter than most others, as far as it reaches inwards from there. Leaves other volumes as they are.
/// Returns the number of voxels.
std::size_t ClearPadding(Volume& volume);

}  // namespace kerf
