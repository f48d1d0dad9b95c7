// Makes the bone of a scene: reads it from a file or generates it.
#pragma once

#include <functional>

#include "bone/vdb/bonefile.h"
#include "kerf/bone.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

/// Replaces the reading of a scene's bone file, or the making of its bone.
using ReadSceneBone = std::function<Bone(const ReadBoneOptions&)>;

/// Makes the bone with the scene's material. `material` (optional) receives a summary of it. `progress` (optional) is
/// called with values from 0 to 1; it may throw Cancelled. `read` (optional) is called in place of ReadBone() for
/// the scene's bone file, which then need not exist, and in place of making a bone that the scene describes. Throws
/// kerf::Error.
Bone MakeSceneBone(const Scene& scene, const std::function<void(double)>& progress, MaterialSummary* material = nullptr,
                   const ReadSceneBone& read = {});

}  // namespace kerf
