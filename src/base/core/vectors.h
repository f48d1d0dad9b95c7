// Checks of vectors from external sources.
#pragma once

#include <cmath>

#include "kerf/geometry.h"

namespace kerf {

/// Tick-safe.
inline bool IsFinite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// Returns `v`, shortened if needed so that neither std::hypot nor the square root of the sum of squares of its
/// components exceeds `limit`. The direction is preserved up to rounding; a vector that is short enough is returned
/// unchanged. Returns zero if `limit` is 0 or `v` is not finite. Tick-safe.
Vec3 LimitLength(const Vec3& v, double limit);

}  // namespace kerf
