// The connected parts of a triangle surface: which way they face, and which lies in which.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

struct EdgeCounts {
  std::size_t open = 0;     // of one triangle only
  std::size_t crowded = 0;  // of more than two
};
/// Whichever way the triangles face.
EdgeCounts CountEdges(const TriangleMesh& mesh);

/// Triangles that are joined by edges.
struct Shell {
  std::vector<std::uint32_t> triangles;
  double volume_mm3 = 0;  // negative when it faces inward
  Box3 box;
  int container = -1;  // the smallest shell that it lies in; -1: none
};

/// The shells of a surface each of whose edges belongs to two triangles, largest volume first. Triangles that face the
/// other way than most of their shell are turned and counted. Throws Error, beginning with `path`, for a shell with one
/// side only.
std::vector<Shell> OrientShells(TriangleMesh& mesh, std::size_t& turned, const std::string& path);

/// Sets the containers. The shells must not cross each other; they come largest first.
void FindContainers(const TriangleMesh& mesh, std::vector<Shell>& shells);

/// Points of no triangle go.
void DropUnusedPoints(TriangleMesh& mesh);

}  // namespace kerf
