// The bone that a scene names: read from its file or generated.
#pragma once

#include <functional>

#include "kerf/bone.h"
#include "scene/scene.h"

namespace kerf {

/// `progress` gets 0..1; may be empty. Throws Error.
Bone MakeSceneBone(const Scene& scene, const std::function<void(double)>& progress);

}  // namespace kerf
