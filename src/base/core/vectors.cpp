#include "base/core/vectors.h"

#include <algorithm>
#include <limits>

namespace kerf {

Vec3 LimitLength(const Vec3& v, double limit) {
  if (!IsFinite(v) || !(limit > 0)) return Vec3{0};
  const double largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
  if (largest == 0) return v;
  const Vec3 u(v.x / largest, v.y / largest, v.z / largest);
  const double u_length = std::sqrt(glm::dot(u, u));  // 1 to sqrt(3)
  // Each rounding error here is a few units of 2^-53; a margin of 16 epsilon covers them all.
  constexpr double kShort = 1 - 16 * std::numeric_limits<double>::epsilon();
  if (largest <= kShort * limit / u_length) return v;
  return (kShort * limit / u_length) * u;
}

}  // namespace kerf
