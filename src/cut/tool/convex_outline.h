// Convex polygon in the x-y plane of the tool frame T: the outline of a blade that is not round. Tick-safe.
#pragma once

#include <array>
#include <span>

#include "kerf/geometry.h"

namespace kerf {

/// Corners in counter-clockwise order around z, mm.
class ConvexOutline {
 public:
  static constexpr int kMaxCorners = 32;
  struct Point {
    double x = 0, y = 0;
  };
  /// Side of the outline from a corner to the next: points with normal . p <= offset lie within it.
  struct Side {
    Point normal;  // unit length
    double offset_mm = 0;
  };

  /// Sides that belong to the edge of a blade, and what they sweep: those whose normal has an x above `least_x` or a y
  /// above `least_y`.
  struct Cutting {
    double least_x = 2, least_y = 2;
  };

  ConvexOutline() = default;
  /// Makes the hull of any points. Corners beyond kMaxCorners are an error (assert).
  static ConvexOutline MakeHull(std::span<const Point> points, const Cutting& cutting);

  bool empty() const { return count_ == 0; }
  int size() const { return count_; }
  const Point& corner(int i) const { return corners_[static_cast<std::size_t>(i)]; }
  /// Side from corner i to corner i + 1.
  Side side(int i) const;
  const Cutting& cutting() const { return cutting_; }
  bool Cuts(const Side& side) const { return side.normal.x > cutting_.least_x || side.normal.y > cutting_.least_y; }
  /// Distance from the outline, mm; negative inside, where it is exact too.
  double CalcSignedDistance(const Point& p) const;
  /// Returns the nearest point of the polygon; the point itself inside.
  Point FindNearest(const Point& p) const;

 private:
  Point FindNearestOnSide(int i, const Point& p) const;

  Cutting cutting_;
  int count_ = 0;
  std::array<Point, kMaxCorners> corners_{};
};

}  // namespace kerf
