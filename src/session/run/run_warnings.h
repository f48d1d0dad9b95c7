// Warnings after a run along a path, for the terminal and for its summary.
#pragma once

#include <string>
#include <vector>

#include "session/run/run_scene.h"
#include "session/run/run_slab_scene.h"

namespace kerf {

/// These return the warnings, one sentence each.
std::vector<std::string> FindRunWarnings(const Scene& scene, const RunSummary& summary);
std::vector<std::string> FindSlabRunWarnings(const Scene& scene, const SlabSummary& summary);

}  // namespace kerf
