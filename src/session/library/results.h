// Runs and replays with the results that the public headers state.
#pragma once

#include <functional>
#include <optional>

#include "kerf/run.h"
#include "session/run/event_check.h"
#include "session/run/loop_options.h"
#include "session/run/path_tape.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

inline std::optional<ReplayDifference> ToDifference(const std::optional<Divergence>& divergence) {
  if (!divergence) return {};
  return ReplayDifference{divergence->time_s, divergence->what};
}

/// Progress of the ticks, 0 to 1; may throw Cancelled.
using TickProgress = std::function<void(double)>;

// The warnings of the runs are those of `kerf run`.
PathRun RunVoxelPath(const Scene& scene, Bone bone, MaterialSummary material, const TickProgress& progress,
                     const PathTape& tape);
PathRun RunSlabPath(const Scene& scene, const Bone& bone, MaterialSummary material, const TickProgress& progress,
                    const PathTape& tape);
/// Throws Cancelled if `progress` returns false. Sets the outputs and watchers of `loop`. `stop` (optional): as in
/// HandRunOptions.
HandRun RunHandLoop(const Scene& scene, LoopOptions loop, const std::atomic<bool>* stop, const ShowProgress& progress);

}  // namespace kerf
