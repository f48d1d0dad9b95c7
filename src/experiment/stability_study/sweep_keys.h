// The numeric keys of a scene, with the values that a sweep needs.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

struct SweepKey {
  std::string name;  // "coupling.stiffness_N_per_mm"
  double least = 0;
  double greatest = 0;
  double default_value = 0;  // default in the schema
  double own = 0;            // the scene's value
};

/// Returns all keys with a single number, of the sections that the scene has and of [coupling], [device], [hand] and
/// [loop], in the order of a resolved scene. Only the first of several strokes is included. Vectors, words and switches
/// are left out.
std::vector<SweepKey> ListSweepKeys(const Scene& scene);

/// Throws Error if the scene has no such key.
void SetSweepKey(Scene& scene, const std::string& name, double value);

}  // namespace kerf
