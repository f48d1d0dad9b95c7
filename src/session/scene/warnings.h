// Warnings about settings that are valid in a scene but rarely intended.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

/// Returns the bite if the tool moves straight into the bone at the path's maximum speed, mm: v / (teeth rpm / 60).
/// Infinite for a stopped spindle.
double CalcMaxBite(const Scene& scene);

/// Returns the warnings, one sentence each. `voxel_mm`: of the bone; 0 if unknown.
std::vector<std::string> FindWarnings(const Scene& scene, double voxel_mm);
/// Returns the warnings that apply to a coupled simulation, in which the tool follows the hand and not the path.
std::vector<std::string> FindToolWarnings(const Scene& scene, double voxel_mm);

}  // namespace kerf
