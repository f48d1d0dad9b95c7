// How a blade with a stroke is held to saw downwards.
#pragma once

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

#include "kerf/geometry.h"

namespace kerf {

/// Returns the orientation of T in a frame in which the teeth face -z, the edge lies along x, and the blade in the x-z
/// plane.
inline Quat CalcEdgeDown() {
  return glm::quat_cast(glm::dmat3(Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(0, -1, 0)));
}

}  // namespace kerf
