// Restoration of bone that was taken out.
#pragma once

#include <vector>

#include "kerf/bone.h"

namespace kerf {

/// Returns the bone with the pieces added where they were cut off: the cut is again what it was in them and in the kerf
/// around them, exactly, if the bone was not cut meanwhile. A wall within three voxels of a piece that was cut after
/// the piece had been taken out is moved back by up to a quarter of a voxel. The pieces must have been taken out of the
/// bone (MakePieceRemoval()), not cut away. Empty pieces are ignored. Throws kerf::Error if the voxel sizes differ.
Bone JoinBones(const Bone& bone, const std::vector<const Bone*>& pieces);

}  // namespace kerf
