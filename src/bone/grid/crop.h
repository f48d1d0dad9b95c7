// Part of a bone, for repeated work around one place.
#pragma once

#include "kerf/bone.h"

namespace kerf {

/// Returns the part of the bone within the box, extended to whole leaves; outside it there is air. Distances near the
/// faces of the box are not valid and must not be used. Returns a copy of the whole bone if the box contains all of it
/// or is empty.
Bone CropBone(const Bone& bone, const Box3& box_W);

}  // namespace kerf
