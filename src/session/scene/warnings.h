// Warnings about settings that are valid in a scene but rarely intended.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

/// Returns the bite if the tool moves straight into the bone at the path's maximum speed, mm: v / (teeth rpm / 60).
/// Infinite for a stopped spindle.
double CalcMaxBite(const Scene& scene);

inline constexpr const char* kStoppedWarning = "rpm = 0: a stopped tool cuts nothing";

/// Returns the warnings about the voxels and the samples of the rim, one sentence each. `voxel_mm`: of the bone; 0 if
/// unknown.
std::vector<std::string> FindVoxelWarnings(const SimulationParams& params, double voxel_mm);
/// Returns the warnings about a law that is used for bites up to `bite_mm`.
std::vector<std::string> FindLawWarnings(const SimulationParams& params, double bite_mm);
/// Returns the warning about a direction of the osteons that the law does not read.
std::string DescribeUnusedDirection(const ForceLaw& law);

/// Returns the warnings, one sentence each. `voxel_mm`: of the bone; 0 if unknown.
std::vector<std::string> FindWarnings(const Scene& scene, double voxel_mm);
/// Returns the warnings that apply to a coupled simulation, in which the tool follows the hand and not the path.
std::vector<std::string> FindToolWarnings(const Scene& scene, double voxel_mm);

}  // namespace kerf
