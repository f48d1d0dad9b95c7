// Checks what the surface readers guarantee.
#pragma once

#include "kerf/geometry.h"
#include "target.h"

namespace kerf::fuzz {

inline void CheckMesh(const TriangleMesh& mesh) {
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t id : triangle) {
      if (id >= mesh.points.size()) Finding("a triangle refers to a point that does not exist");
    }
  }
}

}  // namespace kerf::fuzz
