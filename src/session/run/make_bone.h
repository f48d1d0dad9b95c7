// The bone that a scene names: read from its file or generated.
#pragma once

#include <functional>

#include "kerf/bone.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

/// With the scene's material in it; `material`, unless null, gets what there is to say of that. `progress` gets 0..1;
/// may be empty. Throws Error.
Bone MakeSceneBone(const Scene& scene, const std::function<void(double)>& progress,
                   MaterialSummary* material = nullptr);

}  // namespace kerf
