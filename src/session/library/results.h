// Runs and replays with the results that the public headers state.
#pragma once

#include <optional>

#include "kerf/run.h"
#include "session/run/event_check.h"
#include "session/run/loop_options.h"
#include "session/run/path_tape.h"
#include "session/scene/scene.h"

namespace kerf {

/// Returns progress from `from` to `to` for a part of the work.
inline ShowProgress PartOf(const ShowProgress& progress, double from, double to) {
  if (!progress) return {};
  return [&progress, from, to](double fraction) { return progress(from + (to - from) * fraction); };
}

inline std::optional<ReplayDifference> ToDifference(const std::optional<Divergence>& divergence) {
  if (!divergence) return {};
  return ReplayDifference{divergence->time_s, divergence->what};
}

// The following throw Cancelled if `progress` returns false.
PathRun RunVoxelPath(const Scene& scene, Bone bone, const ShowProgress& progress, const PathTape& tape);
PathRun RunSlabPath(const Scene& scene, const Bone& bone, const ShowProgress& progress, const PathTape& tape);
/// Sets the outputs and watchers of `loop`. `stop` (optional): as in HandRunOptions.
HandRun RunHandLoop(const Scene& scene, LoopOptions loop, const std::atomic<bool>* stop, const ShowProgress& progress);

}  // namespace kerf
