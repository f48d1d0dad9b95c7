// A surface as it was read, made into closed shells: small faults are repaired and reported, others are named.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Points of a surface that is not closed are welded when they are nearer to each other than this.
inline constexpr double kWeld_mm = 0.01;

/// What was found of a surface, and done to it.
struct SurfaceReport {
  std::size_t triangles = 0;
  std::size_t shells = 0;              // connected parts of the surface
  std::size_t hollow_shells = 0;       // around a hollow
  std::size_t inner_solid_shells = 0;  // within the solid, and without effect
  double hollow_mm3 = 0;               // of all hollows, less the solid that lies in them
  std::string how;                     // the same in words, and why
  std::vector<std::string> repairs;    // a sentence each
};

struct ClosedSurface {
  /// What the first encloses is solid, what the second encloses is hollow, what the third encloses is solid again, and
  /// so on. Each is closed. Shells of one layer may lie within each other.
  std::vector<TriangleMesh> layers;
  SurfaceReport report;
};

/// A shell within another is a hollow when the two face opposite ways, or whichever way they face when
/// `hollow_inner_shells`. An outermost shell is solid whichever way it faces.
///
/// Welds points as above, leaves out all but one of triangles that have the same corners, turns those that face the
/// other way than most of their shell. Throws Error, beginning with `path`, that names what else keeps the surface from
/// being closed: edges of one triangle only, edges of more than two, shells with one side only.
ClosedSurface CloseSurface(TriangleMesh mesh, bool hollow_inner_shells, const std::string& path);

}  // namespace kerf
