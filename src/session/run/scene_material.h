// Sets the bone's stiffness from the source that the scene selects.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "bone/grid/ct_modulus.h"
#include "kerf/bone.h"
#include "session/scene/scene.h"

namespace kerf {

/// Summary of the material, for the report of a run.
struct MaterialSummary {
  MaterialKind kind = MaterialKind::kRegions;
  CtLaw law;  // with the calibration used; this and the members below: only for kCt
  bool own_calibration = true;
  CtModulusReport ct;
  std::vector<int> ct_regions;        // regions that take E from the CT
  std::vector<std::string> warnings;  // one sentence each
};

/// Throws kerf::Error if the law is unknown or does not fit its calibration, or if the bone has no CT numbers.
MaterialSummary ApplySceneMaterial(const Scene& scene, Bone& bone);

/// Describes the material in one readable line.
std::string DescribeMaterial(const Scene& scene, const MaterialSummary& summary);
/// Returns the object "material" of summary.json.
nlohmann::ordered_json MaterialJson(const Scene& scene, const MaterialSummary& summary);

}  // namespace kerf
