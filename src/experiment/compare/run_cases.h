// One case of a comparison, run once.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "experiment/compare/comparison.h"
#include "kerf/bone.h"
#include "kerf/slab.h"
#include "session/scene/scene.h"

namespace kerf {

struct CaseRun {
  std::vector<DepthSample> samples;  // of every tick
  Percentiles times;
  double work_mJ = 0;
  double removed_mm3 = 0;
  std::uint64_t force_hash = 0;
  std::optional<std::uint64_t> bone_hash;
  std::uint64_t memory_bytes = 0;
};

/// Runs a case once. `profile` provides the depths and, for a slab case, the layers. `progress` receives 0..1 and may
/// be empty. Throws Error if the case cannot run.
CaseRun RunCase(const CompareCase& what, const Scene& scene, const Bone& bone, const SlabProfile& profile,
                const std::function<void(double)>& progress);

}  // namespace kerf
