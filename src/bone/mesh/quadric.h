// Quadric error of a point: the weighted sum of its squared distances from a set of planes.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "kerf/geometry.h"

namespace kerf {

/// q(x) = x^T A x + 2 b^T x + c, A symmetric and positive semidefinite [Garland and Heckbert 1997]. Units mm^2 x
/// weight.
struct Quadric {
  double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;  // A
  Vec3 b{0};
  double c = 0;
  double weight = 0;

  /// Returns the quadric of the plane through p with unit normal n.
  static Quadric OfPlane(const Vec3& n, const Vec3& p, double weight) {
    const double d = -glm::dot(n, p);
    return {weight * n.x * n.x, weight * n.x * n.y, weight * n.x * n.z,
            weight * n.y * n.y, weight * n.y * n.z, weight * n.z * n.z,
            weight * d * n,     weight * d * d,     weight};
  }
  Quadric& operator+=(const Quadric& o) {
    xx += o.xx, xy += o.xy, xz += o.xz, yy += o.yy, yz += o.yz, zz += o.zz;
    b += o.b, c += o.c, weight += o.weight;
    return *this;
  }
  double operator()(const Vec3& x) const {
    const Vec3 Ax{xx * x.x + xy * x.y + xz * x.z, xy * x.x + yy * x.y + yz * x.z, xz * x.x + yz * x.y + zz * x.z};
    return glm::dot(x, Ax) + 2 * glm::dot(b, x) + c;
  }
  /// Returns the point of minimum error. In directions that the planes do not constrain (a flat part, a straight edge)
  /// it is pulled to `anchor`, with 1e-6 of the weight. This is too weak to move it off a plane by more than a
  /// millionth of its distance from the anchor.
  Vec3 CalcMinimum(const Vec3& anchor) const {
    const double pull = 1e-6 * weight;
    // Cholesky factorisation, with the anchor as the origin.
    const Vec3 g{xx * anchor.x + xy * anchor.y + xz * anchor.z + b.x,
                 xy * anchor.x + yy * anchor.y + yz * anchor.z + b.y,
                 xz * anchor.x + yz * anchor.y + zz * anchor.z + b.z};
    const double l00 = std::sqrt(xx + pull);
    if (!(l00 > 0)) return anchor;
    const double l10 = xy / l00;
    const double l20 = xz / l00;
    const double l11 = std::sqrt(yy + pull - l10 * l10);
    const double l21 = (yz - l20 * l10) / l11;
    const double l22 = std::sqrt(zz + pull - l20 * l20 - l21 * l21);
    const double y0 = -g.x / l00;
    const double y1 = (-g.y - l10 * y0) / l11;
    const double y2 = (-g.z - l20 * y0 - l21 * y1) / l22;
    const double z = y2 / l22;
    const double y = (y1 - l21 * z) / l11;
    const double x = (y0 - l10 * y - l20 * z) / l00;
    const Vec3 minimum = anchor + Vec3{x, y, z};
    return std::isfinite(x + y + z) ? minimum : anchor;
  }
};

/// Returns whether a triangle with the normal `before` (any length; 0: no normal to preserve) may be given the corners
/// `p`. The angle between its old and new normals must have a cosine of at least `min_cosine`, and it must not be a
/// sliver: the square of its longest side must be less than `worst_shape` times twice its area.
inline bool KeepsTriangleShape(const Vec3& before, const Vec3 (&p)[3], double min_cosine, double worst_shape) {
  const Vec3 after = glm::cross(p[1] - p[0], p[2] - p[0]);
  const double area_before = glm::length(before);
  const double area_after = glm::length(after);
  if (area_before > 0 && glm::dot(before, after) < min_cosine * area_before * area_after) return false;
  const auto length2 = [](const Vec3& v) { return glm::dot(v, v); };
  return std::max({length2(p[1] - p[0]), length2(p[2] - p[1]), length2(p[0] - p[2])}) < worst_shape * area_after;
}

}  // namespace kerf
