// What a vector that came from elsewhere is asked before it is believed.
#pragma once

#include <cmath>

#include "kerf/geometry.h"

namespace kerf {

/// Tick-safe.
inline bool IsFinite(const Vec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

/// `v` shortened so that neither std::hypot nor the square root of the sum of squares of its components is above
/// `limit`, its direction kept to rounding; as it is when it is short enough. Zero for a limit of 0 or a vector that is
/// not finite. Tick-safe.
Vec3 LimitLength(const Vec3& v, double limit);

}  // namespace kerf
