// Signed distances of simple solids, mm, negative inside, and smooth combinations of them. All tick-safe.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

using Vec2 = glm::dvec2;

/// Returns the union, with a fillet at its seam. It differs from the smaller value only where the two differ by less
/// than k mm, and by at most k/4.
inline double SmoothUnion(double a, double b, double k) {
  const double h = std::max(k - std::abs(a - b), 0.0) / k;
  return std::min(a, b) - 0.25 * h * h * k;
}

/// Returns the difference, `a` without `b`, with a fillet as in SmoothUnion().
inline double SmoothDifference(double a, double b, double k) {
  return -SmoothUnion(-a, b, k);
}

/// Returns the intersection, with its edge rounded to a quarter circle of radius r (both negative inside).
inline double RoundedIntersection(double a, double b, double r) {
  const double u = std::max(a + r, 0.0);
  const double v = std::max(b + r, 0.0);
  return std::sqrt(u * u + v * v) + std::min(std::max(a, b) + r, 0.0) - r;
}

/// Returns 3t^2 - 2t^3, where t is the position of x between a and b, clamped to 0 to 1.
inline double SmoothStep(double a, double b, double x) {
  const double t = std::clamp((x - a) / (b - a), 0.0, 1.0);
  return t * t * (3 - 2 * t);
}

inline double Mix(double a, double b, double t) {
  return a + t * (b - a);
}

/// Two balls and the cone that touches both; Vec is Vec2 or Vec3. Exact (after I. Quilez, rounded cone).
template <typename Vec>
class RoundedCone {
 public:
  RoundedCone() = default;
  RoundedCone(const Vec& a, const Vec& b, double radius_a, double radius_b)
      : a_(a), axis_(b - a), radius_a_(radius_a), radius_b_(radius_b) {
    length2_ = glm::dot(axis_, axis_);
    const double difference = radius_a - radius_b;
    a2_ = length2_ - difference * difference;  // > 0 unless one ball contains the other
    inverse_length2_ = length2_ > 0 ? 1 / length2_ : 0;
  }

  double Distance(const Vec& p) const {
    const Vec pa = p - a_;
    if (!(a2_ > 0)) {
      const double to_a = glm::length(pa) - radius_a_;
      return std::min(to_a, glm::length(pa - axis_) - radius_b_);
    }
    const double difference = radius_a_ - radius_b_;
    const double y = glm::dot(pa, axis_);
    const double z = y - length2_;
    const Vec across = pa * length2_ - axis_ * y;
    const double x2 = glm::dot(across, across);
    const double y2 = y * y * length2_;
    const double z2 = z * z * length2_;
    const double k = (difference > 0 ? 1 : difference < 0 ? -1 : 0) * difference * difference * x2;
    if ((z > 0 ? 1 : -1) * a2_ * z2 > k) return std::sqrt(x2 + z2) * inverse_length2_ - radius_b_;
    if ((y > 0 ? 1 : -1) * a2_ * y2 < k) return std::sqrt(x2 + y2) * inverse_length2_ - radius_a_;
    return (std::sqrt(x2 * a2_ * inverse_length2_) + y * difference) * inverse_length2_ - radius_a_;
  }

 private:
  Vec a_{0};
  Vec axis_{0};
  double radius_a_ = 0;
  double radius_b_ = 0;
  double length2_ = 0;
  double a2_ = 0;
  double inverse_length2_ = 0;
};

/// Returns the distance from a point to a box; 0 inside.
inline double BoxDistance(const Box3& box, const Vec3& p) {
  return glm::length(glm::max(glm::max(box.lower - p, p - box.upper), Vec3{0}));
}

/// Union of rounded cones without fillets, with a box around them so that the evaluation is fast at distant points.
class RoundedCones {
 public:
  void Add(const Vec3& a, const Vec3& b, double radius_a, double radius_b) {
    const double reach = 0.5 * glm::distance(a, b) + std::max(radius_a, radius_b);
    cones_.push_back({RoundedCone<Vec3>(a, b, radius_a, radius_b), 0.5 * (a + b), reach + kRounding_mm});
    box_.Include(a - radius_a);
    box_.Include(a + radius_a);
    box_.Include(b - radius_b);
    box_.Include(b + radius_b);
  }
  /// If the distance exceeds `limit`, any value larger than `limit` may be returned.
  double Distance(const Vec3& p, double limit) const {
    double best = limit + 1e-6;
    if (BoxDistance(box_, p) > limit) return best;
    for (const BoundedCone& c : cones_) {
      const Vec3 d = p - c.centre;
      const double within_mm = best + c.reach;  // of its centre; farther away, the cone is too far as well
      if (within_mm > 0 && glm::dot(d, d) < within_mm * within_mm) best = std::min(best, c.cone.Distance(p));
    }
    return best;
  }

 private:
  static constexpr double kRounding_mm = 1e-9;
  struct BoundedCone {
    RoundedCone<Vec3> cone;
    Vec3 centre{0};    // of a ball that contains it
    double reach = 0;  // its radius
  };
  std::vector<BoundedCone> cones_;
  Box3 box_;
};

/// Returns the approximate distance to an ellipsoid at the origin: exact on the surface, and only slightly too large
/// near it.
inline double EllipsoidDistance(const Vec3& p, const Vec3& radii) {
  const double k0 = glm::length(p / radii);
  const double k1 = glm::length(p / (radii * radii));
  const double smallest = std::min({radii.x, radii.y, radii.z});
  return k1 > 0 ? std::max(k0 * (k0 - 1) / k1, -smallest) : -smallest;
}

}  // namespace kerf
