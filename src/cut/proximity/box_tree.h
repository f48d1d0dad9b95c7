// Hierarchy of boxes that finds the box nearest to a point.
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Part of a tool: a round plate, in the world frame.
struct Plate {
  Vec3 centre_W{0};
  Vec3 normal_W{0, 0, 1};  // unit length
  double radius_mm = 0;
  double half_thickness_mm = 0;
};

/// Hierarchy of fixed axis-aligned boxes. Embree's bounding volume hierarchy finds candidates in single precision,
/// rounded so that none is lost. Distances are computed in double from the boxes themselves and do not depend on the
/// structure of the hierarchy.
class BoxTree {
 public:
  /// `boxes`: world frame, mm. Allocates. Throws Error if Embree cannot be started.
  explicit BoxTree(const std::vector<Box3>& boxes);
  ~BoxTree();
  BoxTree(BoxTree&&) noexcept;
  BoxTree& operator=(BoxTree&&) noexcept;

  struct Nearest {
    double distance_mm = 0;  // 0 inside a box
    Vec3 p_W{0};             // nearest point of the box; the queried point if no box is within the limit
  };
  /// Returns the box nearest to a point if it is within `limit_mm`; otherwise the distance is `limit_mm`. A tighter
  /// limit makes the search faster. Boxes are stored rounded outwards, so a distance may be too small by up to 1e-6 of
  /// the bone's size. Tick-safe.
  Nearest FindNearest(const Vec3& p_W, double limit_mm) const;

  /// Returns a lower bound on the distance from a plate to the nearest box, mm. It is negative where they may overlap,
  /// and `limit_mm` if no box is nearer than that. Each box is replaced by the half space behind the plane through its
  /// point nearest to the plate's centre. The search stops at the first box with a bound of at most `enough_mm` and
  /// then returns some value of at most `enough_mm`. Tick-safe.
  double CalcPlateBound(const Plate& plate, double limit_mm, double enough_mm) const;

  /// Returns the distance from a point to the box around all boxes, mm: a lower bound on the distance to the nearest
  /// box, and fast to compute. Tick-safe.
  double CalcDistanceToAll(const Vec3& p_W) const;

  std::size_t size() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
