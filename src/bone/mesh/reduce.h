// Fewer triangles within a stated error.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// What a run's pieces are reduced to when nothing else is asked for.
inline constexpr double kSurfaceErrorMm = 0.02;

struct ReducedMesh {
  TriangleMesh mesh;
  std::vector<std::uint32_t> from;  // for each point one of the full surface that has the same label, and is near
};

/// The surface with as few triangles as edge collapses leave within `error_mm` of the full one, either way: each point
/// of the full surface is kept with a triangle that is so near, and a collapse that would leave one without is not
/// made; at edges and in gaps what lies between points is compared as well. Nothing is torn, pinched or folded, so a
/// closed surface stays closed and of the same genus; the rim of an open one stays as it is.
///
/// The bound is one of construction at points and of measurement between them: at 0.02 mm at most 0.97 of it was
/// measured, on mandibles of 0.15 to 1 mm voxels, whole and cut, and on blocks with oblique cuts; at 0.01 and 0.04 mm
/// at most 1.09 times the error.
///
/// `labels`, when given, has one for each point (a tissue, a colour): points that have a neighbour with another label
/// stay where they are, so that the border between labels keeps its full resolution.
///
/// Threads share the work; the result does not depend on their number. 2.7 million triangles: 9 s of one core and
/// 0.6 GB. Throws Error when an error is not above 0 or the labels are not as many as the points.
ReducedMesh Reduce(const TriangleMesh& mesh, double error_mm, std::span<const std::uint32_t> labels = {});
/// The same in steps, each from the one before, for hardly more than the last alone: `errors_mm`, ascending, are all
/// from the full surface.
std::vector<ReducedMesh> ReduceInSteps(const TriangleMesh& mesh, std::span<const double> errors_mm,
                                       std::span<const std::uint32_t> labels = {});

}  // namespace kerf
