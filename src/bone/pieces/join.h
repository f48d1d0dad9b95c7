// Bone that was taken out, put back.
#pragma once

#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// The bone with the pieces where they were cut off: what was taken out of it has not been cut away. Pieces without
/// bone are passed over. Throws Error when the voxels differ.
Bone JoinBones(const Bone& bone, const std::vector<const Bone*>& pieces);

}  // namespace kerf
