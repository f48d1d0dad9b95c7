// How far the surface of a bone made from a CT is expected to lie from the scanned body's.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "bone/import/ct_solid.h"
#include "bone/import/isolate.h"

namespace kerf {

/// Above this expected error the user is warned, mm.
inline constexpr double kSurfaceErrorToWarn_mm = 0.3;

/// Distances along the normal between the surface and the true edge of bone, over the outer surface of the solid. The
/// true edge is taken to be where the HU are half way between the soft tissue outside and the brightest bone below the
/// surface: exact for the flat face of bone that is thicker than about three standard deviations of the blur.
struct SurfaceError {
  int points = 0;             // of the surface, at which it was measured; 0: unknown
  double offset_mm = 0;       // median; positive: the surface lies outside the edge
  double scatter_mm = 0;      // rms of what the spacing of the samples adds, either way
  double blur_mm = 0;         // standard deviation of the CT's blur, across the edges that are sampled most finely
  double half_height_hu = 0;  // median: the iso value that would give an offset of 0

  /// Root mean square, mm: offset and scatter together.
  double CalcExpected() const { return std::hypot(offset_mm, scatter_mm); }
};

/// Measures offset and blur on the HU along about 4000 normals, and derives the scatter from blur and spacing.
SurfaceError CalcSurfaceError(const CtSolid& solid, const Isolation& isolation,
                              const std::vector<std::uint8_t>& cavities);

}  // namespace kerf
