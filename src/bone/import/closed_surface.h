// Conversion of a surface to closed shells: small faults are repaired and reported, others cause an error.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// In a surface that is not closed, points closer to each other than this are welded.
inline constexpr double kWeld_mm = 0.01;

/// Results and repairs of CloseSurface().
struct SurfaceReport {
  std::size_t triangles = 0;
  std::size_t shells = 0;              // connected parts of the surface
  std::size_t hollow_shells = 0;       // shells that enclose a hollow
  std::size_t inner_solid_shells = 0;  // solid shells within the solid; no effect
  double hollow_mm3 = 0;               // volume of all hollows, minus that of the solid inside them
  std::string how;                     // summary of the shells, in words
  std::vector<std::string> repairs;    // one sentence each
};

struct ClosedSurface {
  /// Closed layers. The first encloses the solid, the second hollows in it, the third solids within these, and so on.
  /// Shells of one layer may be nested.
  std::vector<TriangleMesh> layers;
  SurfaceReport report;
};

/// Makes closed layers from a mesh. A shell inside another one is a hollow if they face in opposite directions, or in
/// any case if `hollow_inner_shells` is true. An outermost shell is solid whichever way it faces.
///
/// Welds points as described above, removes all but one of the triangles with the same corners, and flips triangles
/// that face opposite to most of their shell. Throws kerf::Error, whose message begins with `path`, if the surface is
/// then still not closed: if it has edges of only one triangle, edges of more than two, or one-sided shells.
ClosedSurface CloseSurface(TriangleMesh mesh, bool hollow_inner_shells, const std::string& path);

}  // namespace kerf
