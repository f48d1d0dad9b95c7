// Normals of a surface for drawing: smooth, except at sharp edges.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

struct CreasedMesh {
  TriangleMesh mesh;                    // the same triangles; points at sharp edges are repeated at the end
  std::vector<std::uint32_t> repeated;  // of which points, in order
  std::vector<glm::vec3> normals;       // of the points, of unit length; the mean of their triangles' normals
};

/// Splits a surface where triangles with a common side are at an angle of 40 degrees or more. Around each point, the
/// triangles that are connected by smoother sides share one normal.
CreasedMesh SplitAtCreases(const TriangleMesh& mesh);

}  // namespace kerf
