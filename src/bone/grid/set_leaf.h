// Writing and reading a leaf of a bone's level set as a whole.
#pragma once

#include <array>
#include <span>

#include "kerf/bone.h"

namespace kerf {

/// Gives the leaf of number `index` (along each axis the voxel's index divided by 8, rounded down) these values: mm, z
/// fastest, y next. The bookkeeping of active voxels follows the band. Allocates when the bone had no such leaf.
void SetLeaf(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> values);

/// The values of that leaf, wherever it is: +-band where the bone has one value for all of it.
void GetLeaf(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> values);

}  // namespace kerf
