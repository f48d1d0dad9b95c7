// Part of a bone, for repeated work around one place.
#pragma once

#include "kerf/bone.h"

namespace kerf {

/// Returns the part of the bone within the box, extended to whole leaves; outside there is air. Distances at the faces
/// of the box are not valid: keep away from them. Returns a copy of the whole bone if the box contains all of it or is
/// empty.
Bone CropBone(const Bone& bone, const Box3& box_W);

}  // namespace kerf
