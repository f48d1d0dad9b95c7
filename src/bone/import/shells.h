// Connected parts of a triangle surface: their orientation and their nesting.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

struct EdgeCounts {
  std::size_t open = 0;     // edges of only one triangle
  std::size_t crowded = 0;  // edges of more than two
};
/// Counts such edges, regardless of the triangles' orientation.
EdgeCounts CountEdges(const TriangleMesh& mesh);

/// Triangles that are connected by edges.
struct Shell {
  std::vector<std::uint32_t> triangles;
  double volume_mm3 = 0;  // negative if it faces inward
  Box3 box;
  int container = -1;  // the smallest shell that contains it; -1: none
};

/// Returns the shells of a surface in which each edge belongs to two triangles, largest volume first. Triangles that
/// face opposite to most of their shell are flipped and counted. Throws kerf::Error, whose message begins with `path`,
/// for a one-sided shell.
std::vector<Shell> OrientShells(TriangleMesh& mesh, std::size_t& flipped, const std::string& path);

/// Sets the containers. The shells must not intersect each other and must be sorted, largest first.
void FindContainers(const TriangleMesh& mesh, std::vector<Shell>& shells);

/// Removes points without triangles.
void DropUnusedPoints(TriangleMesh& mesh);

}  // namespace kerf
