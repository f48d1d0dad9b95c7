// A triangle surface in a hierarchy: where a ray meets it, and its point nearest to another.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Embree's hierarchy finds the candidates in single precision, rounded so that none is lost; distances are worked out
/// in double from the triangles themselves. Points are kept about the middle of the surface, to a float's precision of
/// its size. Reading is thread-safe.
class SurfaceTree {
 public:
  /// Allocates. Throws Error when Embree can't be set up.
  explicit SurfaceTree(const TriangleMesh& mesh);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree& operator=(SurfaceTree&&) noexcept;

  struct Hit {
    double way_mm = 0;  // along the ray
    Vec3 p{0};
    std::uint32_t triangle = 0;
  };
  /// The first point where the ray from `origin` along `direction` (any length but 0) meets the surface, from either
  /// side.
  std::optional<Hit> Intersect(const Vec3& origin, const Vec3& direction) const;

  struct Nearest {
    double distance_mm = 0;
    Vec3 p{0};
    std::uint32_t triangle = 0;
  };
  /// None when nothing is nearer than `limit_mm`. The tighter the limit, the quicker.
  std::optional<Nearest> FindNearest(const Vec3& p, double limit_mm) const;

  const Box3& bounds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The point of a triangle nearest to p.
Vec3 FindNearestInTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace kerf
