// Checks a scene beyond its file's syntax, for `kerf check` and `kerf stability --sweep`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/run/loop_setup.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

struct CheckedScene {
  std::string bone;  // readable description: source, size and voxel size
  double voxel_mm = 0;
  MaterialSummary material;
  std::optional<LoopSetup> loop;      // if the scene has any of [device], [hand], [coupling] and [loop]
  std::vector<std::string> warnings;  // one sentence each
};

/// Opens the files that the scene refers to. Throws kerf::Error for everything that `kerf run` or `kerf loop` would
/// reject before the first tick.
CheckedScene CheckWholeScene(const Scene& scene);

}  // namespace kerf
