// What is allowed in a scene and yet seldom meant.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

/// Chip bite at the path's top speed straight into the bone, mm: v / (teeth rpm / 60). Infinite for a stopped spindle.
double CalcTopBite(const Scene& scene);

/// A sentence each. `voxel_mm`: of the bone; 0 when it is not known.
std::vector<std::string> FindDoubts(const Scene& scene, double voxel_mm);
/// Those of them that matter when a hand holds the tool, which goes where it can rather than along the path.
std::vector<std::string> FindToolDoubts(const Scene& scene, double voxel_mm);

}  // namespace kerf
