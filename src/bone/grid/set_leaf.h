// Writing and reading of a leaf of a bone's level set.
#pragma once

#include <array>
#include <functional>
#include <span>

#include "kerf/bone.h"

namespace kerf {

/// Sets the values of the leaf `index` (along each axis the voxel's index divided by 8, rounded down): mm, z fastest, y
/// next. A voxel becomes active if its value lies within the band. Allocates if the bone has no such leaf.
void SetLeaf(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> values);

/// Sets the values of the cut in a leaf, as a simulation reports them (ChangedLeaf::cut), and phi to the larger of
/// these and of the values before the first cut. Allocates if the bone has no such leaf.
void SetCut(Bone& bone, const std::array<int, 3>& index, std::span<const float, 512> cut);
/// Copies the values of the cut in a leaf; all are -band where nothing was cut.
void GetCut(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> cut);

/// Cuts away the space where a function is positive: minus the distance to that space, mm, at a world point. `bounds_W`
/// contains it.
void CutAway(Bone& bone, const Box3& bounds_W, const std::function<double(const Vec3&)>& depth_mm);

/// Copies the values of the leaf at any index to `values`: all are +-band where the bone has one value for the whole
/// leaf.
void GetLeaf(const Bone& bone, const std::array<int, 3>& index, std::span<float, 512> values);

}  // namespace kerf
