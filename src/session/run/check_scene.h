// What `kerf check` holds a scene against, beyond what the reader of the file does: one validation for the command and
// for `kerf stability --sweep`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/run/loop_setup.h"
#include "session/run/scene_material.h"
#include "session/scene/scene.h"

namespace kerf {

struct CheckedScene {
  std::string bone;  // for people: what it is, its size and voxels
  double voxel_mm = 0;
  MaterialSummary material;
  std::optional<LoopSetup> loop;      // where the scene says something of device, hand, coupling or loop
  std::vector<std::string> warnings;  // a sentence each
};

/// Opens what the scene names. Throws Error for what `kerf run` or `kerf loop` would refuse before the first tick.
CheckedScene CheckWholeScene(const Scene& scene);

}  // namespace kerf
