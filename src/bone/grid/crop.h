// A part of a bone, for work that is done around one place over and over.
#pragma once

#include "kerf/bone.h"

namespace kerf {

/// The bone within the box, grown to whole leaves; beyond there is air. What was cut off leaves no true distances at
/// the box's faces: stay clear of them. The bone itself where the box holds all of it.
Bone CropBone(const Bone& bone, const Box3& box_W);

}  // namespace kerf
