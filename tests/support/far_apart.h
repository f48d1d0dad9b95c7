// The largest distance between two surfaces.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/pieces/surface_tree.h"
#include "kerf/geometry.h"

namespace kerf::test {

/// Returns the largest distance from `to` to any corner of `from` or to points on its triangles at most `spacing_mm`
/// apart, clamped to `limit_mm`. A tighter limit is faster.
inline double CalcLargestDistance(const TriangleMesh& from, const TriangleMesh& to, double spacing_mm,
                                  double limit_mm = 1) {
  const SurfaceTree tree(to);
  double largest = 0;
  const auto ask = [&](const Vec3& p) {
    const auto nearest = tree.FindNearest(p, limit_mm);
    largest = std::max(largest, nearest ? nearest->distance_mm : limit_mm);
  };
  for (const auto& t : from.triangles) {
    const Vec3& a = from.points[t[0]];
    const Vec3 u = from.points[t[1]] - a;
    const Vec3 v = from.points[t[2]] - a;
    const double longest_mm = std::max(std::max(glm::length(u), glm::length(v)), glm::length(v - u));
    const int n = std::max(1, static_cast<int>(std::ceil(longest_mm / spacing_mm)));
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) ask(a + u * (1.0 * i / n) + v * (1.0 * j / n));
    }
  }
  return largest;
}

}  // namespace kerf::test
