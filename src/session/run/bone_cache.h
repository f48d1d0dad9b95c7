// Generated bones that are kept on disk, because making one takes longer than reading it.
#pragma once

#include <functional>
#include <string>

#include "bone/models/mandible.h"
#include "kerf/bone.h"

namespace kerf {

/// Largest sum of the files that the cache keeps, bytes. The bones that were used last stay.
inline constexpr double kMaxBoneCacheBytes = 1e9;

/// Returns $XDG_CACHE_HOME/kerf/bones, or ~/.cache/kerf/bones; empty if neither variable is set.
std::string FindBoneCache();
/// Sets the folder in which MakeCachedMandible() keeps bones; it is created when needed. Empty, as at the start: none.
/// Must not be called while a bone is made. Waits as FinishKeepingBones() does.
void SetBoneCache(const std::string& folder);
/// Waits until the bones that were made are kept; they are written in the background. Drops a bone that was begun and
/// not taken.
void FinishKeepingBones();

/// Returns the same bone as MakeMandible(), bit for bit; reads it if the cache has it, otherwise makes it and keeps it.
/// A kept bone is found by its parameters and the program's file, so that another version of kerf makes its own, and
/// is used only if it has the hash that it had when it was kept. If the cache cannot be used, the bone is made.
/// Throws as MakeMandible() does.
Bone MakeCachedMandible(const MandibleParams& params, const MaterialTable& materials,
                        const std::function<void(double)>& progress);

/// Returns whether the cache has a bone for these parameters, without reading it.
bool IsMandibleCached(const MandibleParams& params);

/// Begins to do the same in the background, at most for one bone at a time. The next MakeCachedMandible() for the same
/// parameters takes the bone, or throws what prevented it.
void BeginCachedMandible(const MandibleParams& params, const MaterialTable& materials);

}  // namespace kerf
