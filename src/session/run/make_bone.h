// Makes the bone of a scene: reads it from a file or generates it.
#pragma once

#include <functional>

#include "kerf/bone.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

/// Makes the bone with the scene's material. `material` (optional) receives a summary of it. `progress` (optional) is
/// called with values from 0 to 1. Throws kerf::Error.
Bone MakeSceneBone(const Scene& scene, const std::function<void(double)>& progress,
                   MaterialSummary* material = nullptr);

}  // namespace kerf
