// Reduction of a surface within a stated error.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Default error for the pieces of a run, mm.
inline constexpr double kSurfaceErrorMm = 0.02;

struct ReducedMesh {
  TriangleMesh mesh;
  std::vector<std::uint32_t> from;  // for each point: a nearby point of the full surface with the same label
};

/// Reduces a surface by edge collapses until hardly any further one keeps a distance of at most `error_mm` between the
/// reduced and the full surface, in both directions. Each point of the full surface is assigned to a triangle within
/// that distance, and a collapse that would leave a point without one is rejected. At edges and in gaps, locations
/// between the points are compared as well. Nothing is torn, pinched or folded, so a closed surface stays closed and
/// keeps its genus; the rim of an open surface stays unchanged.
///
/// The bound holds by construction at points and by measurement between them. The largest measured distances were 0.84,
/// 0.92 and 0.61 times `error_mm` at 0.01, 0.02 and 0.04 mm on the larger piece of the default run, without labels,
/// each at 16 and 33 million places, and 0.97 times `error_mm` at 0.02 mm on a whole mandible with voxels of 0.4 mm
/// (Reduce.MandibleStaysWithinTheStatedError).
///
/// `labels`, optional, has one entry for each point (a tissue, a colour). Points that have a neighbour with another
/// label are not moved, so that the border between labels keeps its full resolution.
///
/// Uses several threads; the result does not depend on their number. 2.7 million triangles take 5 s on one core and 0.4
/// GB. `progress` (optional) is called with values from 0 to 1 by this thread. Throws kerf::Error if `error_mm` is not
/// above 0 or the number of labels differs from the number of points.
ReducedMesh Reduce(const TriangleMesh& mesh, double error_mm, std::span<const std::uint32_t> labels = {},
                   const std::function<void(double)>& progress = {});

}  // namespace kerf
