// Expected error of the surface of a bone from a CT, relative to the scanned body.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "bone/import/ct_solid.h"
#include "bone/import/isolate.h"

namespace kerf {

/// The user is warned if the expected error exceeds this, mm.
inline constexpr double kSurfaceErrorWarning_mm = 0.3;

/// Distances along the normal between the surface and the true edge of bone, over the outer surface of the solid. The
/// true edge is assumed where the HU are halfway between the soft tissue outside and the brightest bone below the
/// surface. This is exact for the flat face of bone that is thicker than about three standard deviations of the blur.
struct SurfaceError {
  int points = 0;             // number of surface points measured; 0: unknown
  double offset_mm = 0;       // median; positive: the surface lies outside the edge
  double scatter_mm = 0;      // rms of the variation due to the spacing of the samples
  double blur_mm = 0;         // standard deviation of the CT's blur, across the most finely sampled edges
  double half_height_hu = 0;  // median: the iso value that would give an offset of 0

  /// Returns the rms error due to offset and scatter together, mm.
  double CalcExpected() const { return std::hypot(offset_mm, scatter_mm); }
};

/// Measures offset and blur of the HU along about 4000 normals, and derives the scatter from blur and spacing.
SurfaceError CalcSurfaceError(const CtSolid& solid, const Isolation& isolation,
                              const std::vector<std::uint8_t>& cavities);

}  // namespace kerf
