// Boxes in a hierarchy that finds the nearest one to a point.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// A part of a tool: a round plate. World frame.
struct Plate {
  Vec3 centre_W{0};
  Vec3 normal_W{0, 0, 1};  // unit length
  double radius_mm = 0;
  double half_thickness_mm = 0;
};

/// Axis-aligned boxes that stay as they are. Embree's bounding-volume hierarchy finds the candidates, in single
/// precision and rounded so that none is lost; distances are worked out in double from the boxes themselves and do not
/// depend on how the hierarchy came out.
class BoxTree {
 public:
  /// World frame, mm. Allocates. Throws Error when Embree can't be set up.
  explicit BoxTree(const std::vector<Box3>& boxes);
  ~BoxTree();
  BoxTree(BoxTree&&) noexcept;
  BoxTree& operator=(BoxTree&&) noexcept;

  struct Nearest {
    double distance_mm = 0;  // 0 inside a box
    Vec3 p_W{0};  // the box's point that is nearest; when there is none within the limit, the point asked for
  };
  /// The nearest box to a point, if it is within `limit_mm`; else that limit is the distance. The tighter the limit,
  /// the quicker. Boxes are kept rounded outwards, so a distance may be too small by up to 1e-6 of the bone's size.
  /// Tick-safe.
  Nearest FindNearest(const Vec3& p_W, double limit_mm) const;

  /// A lower bound of the distance from a plate to the nearest box, mm; negative where they may overlap; `limit_mm` if
  /// none is as near. Each box is replaced by the half space behind the plane through its point nearest to the plate's
  /// centre. Stops at the first box that is at most `enough_mm` away and then returns some value that is at most
  /// `enough_mm`. Tick-safe.
  double CalcPlateBound(const Plate& plate, double limit_mm, double enough_mm) const;

  /// From a point to the box around all of them: cheap, and a lower bound of the distance to the nearest. Tick-safe.
  double CalcDistanceToAll(const Vec3& p_W) const;

  std::size_t size() const;
  std::size_t CalcMemoryBytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace kerf
