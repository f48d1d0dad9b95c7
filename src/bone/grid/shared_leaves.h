// Copies of a bone that share most of its memory.
#pragma once

#include <cstdint>

#include "kerf/bone.h"

namespace kerf {

/// Lets CopySharing() share the leaves of phi, except those that were cut. The bone's values stay unchanged.
void ShareLeaves(Bone& bone);

/// Returns a copy of a bone, independent of it like any other copy. The two share the leaves that ShareLeaves() made
/// shareable; a bone in which one of them changes gets its own first. Without ShareLeaves() this is a plain copy.
///
/// Only BoneField, SetLeaf() and SetCut() may change phi of a bone that shares leaves. Plain copies share nothing.
Bone CopySharing(const Bone& bone);

/// Returns the memory of a bone without the leaves that it shares.
std::uint64_t CalcOwnBytes(const Bone& bone);

}  // namespace kerf
