// Where a bone is cut off by the edge of the scan.
#pragma once

#include "bone/import/isolate.h"

namespace kerf {

/// Returns the area of the faces of a bone at which the scan ends, mm^2: at the border of the image, or at padding that
/// reaches from there to the border. One value of air outside a circle around the scan, next to bone without a voxel in
/// between, is also padding. At padding, an area below 10 mm^2 counts as none. `ct`: the whole scan. `isolation`: as
/// Isolate() returns it, but for this area.
double CalcCutArea(const Volume& ct, const Isolation& isolation, double iso_hu);

}  // namespace kerf
