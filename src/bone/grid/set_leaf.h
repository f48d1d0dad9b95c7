// Writing and reading of a whole leaf of a bone's level set.
#pragma once

#include <array>
#include <span>

#include "kerf/bone.h"

namespace kerf {

/// Sets the values of the leaf `index` (along each axis the voxel's index divided by 8, rounded down): mm, z fastest, y
/// next. A voxel becomes active if its value lies within the band. Allocates if the bone has no such leaf.
void SetLeaf(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> values);

/// Copies the values of the leaf at any index to `values`: all are +-band where the bone has one value for the whole
/// leaf.
void GetLeaf(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> values);

}  // namespace kerf
