// Distance of a point from a line segment.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>

#include "kerf/geometry.h"

namespace kerf {

/// Returns the point of the segment nearest to p. The ends may coincide.
inline Vec3 FindNearestOnSegment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const Vec3 d = b - a;
  const double length2 = glm::dot(d, d);
  return a + (length2 > 0 ? std::clamp(glm::dot(p - a, d) / length2, 0.0, 1.0) : 0.0) * d;
}

inline double CalcSegmentDistance(const Vec3& p, const Vec3& a, const Vec3& b) {
  return glm::length(p - FindNearestOnSegment(p, a, b));
}

}  // namespace kerf
