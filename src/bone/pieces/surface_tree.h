// Search tree of a triangle surface: intersection with a ray, and nearest point.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "kerf/geometry.h"

namespace kerf {

/// Embree's tree finds the candidates in single precision, rounded so that none is missed. Distances are computed in
/// double precision from the triangles. Points are stored relative to the centre of the surface, with float precision
/// relative to its size. Reading is thread-safe.
class SurfaceTree {
 public:
  /// Allocates. Throws kerf::Error if Embree cannot be set up.
  explicit SurfaceTree(const TriangleMesh& mesh);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree& operator=(SurfaceTree&&) noexcept;

  struct Hit {
    double distance_mm = 0;  // distance along the ray
    Vec3 p{0};
    std::uint32_t triangle = 0;
  };
  /// Returns the first intersection of the ray from `origin` along `direction` (any length except 0) with the surface,
  /// from either side.
  std::optional<Hit> Intersect(const Vec3& origin, const Vec3& direction) const;

  struct Nearest {
    double distance_mm = 0;
    Vec3 p{0};
    std::uint32_t triangle = 0;
  };
  /// Returns the point of the surface nearest to `p`; empty if nothing is nearer than `limit_mm`. A smaller limit is
  /// faster.
  std::optional<Nearest> FindNearest(const Vec3& p, double limit_mm) const;

  const Box3& bounds() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Returns the point of a triangle nearest to p.
Vec3 FindNearestInTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace kerf
