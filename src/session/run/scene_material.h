// What a scene says the bone's stiffness is taken from, put into the bone.
#pragma once

#include <string>
#include <vector>

#include "bone/grid/ct_modulus.h"
#include "kerf/bone.h"
#include "session/scene/scene.h"

namespace kerf {

/// For the report of a run.
struct MaterialSummary {
  MaterialKind kind = MaterialKind::kRegions;
  CtLaw law;  // with the calibration used; the rest only for kCt
  bool own_calibration = true;
  CtModulusReport ct;
  std::vector<int> ct_regions;        // that take E from the CT
  std::vector<std::string> warnings;  // a sentence each
};

/// Throws Error: the law is unknown or does not fit its calibration, or the bone has no CT numbers.
MaterialSummary ApplySceneMaterial(const Scene& scene, Bone& bone);

/// A line for people, without the key.
std::string DescribeMaterial(const Scene& scene, const MaterialSummary& summary);
/// The object "material" of summary.json, as JSON text.
std::string FormatMaterialJson(const Scene& scene, const MaterialSummary& summary);

}  // namespace kerf
