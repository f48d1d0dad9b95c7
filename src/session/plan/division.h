// Division of removed bone among several cuts: what was removed belongs to the cut that it is nearest to.
#pragma once

#include <cstddef>
#include <vector>

#include "session/plan/edit_plane.h"
#include "session/plan/plan.h"

namespace kerf {

/// Returns the index of the nearest of several cuts; of equally near ones, the first. `count`: at least 1.
/// `distance(i)`: distance from cut i, in any unit; may be negative.
template <typename Distance>
std::size_t FindNearest(std::size_t count, const Distance& distance) {
  std::size_t nearest = 0;
  if (count == 1) return nearest;
  double least = distance(nearest);
  for (std::size_t i = 1; i < count; ++i) {
    const double d = distance(i);
    if (d >= least) continue;
    least = d;
    nearest = i;
  }
  return nearest;
}

/// Divides points among planned planes, by their distance from the planes' rectangles.
class PlaneDivision {
 public:
  explicit PlaneDivision(const std::vector<PlannedPlane>& planes);

  /// Returns the index of the plane that a point belongs to; -1: there are no planes.
  int Find(const Vec3& p_W) const;

 private:
  struct Rectangle {
    Vec3 p_W;
    PlaneAxes axes;
    double half_width_mm, half_height_mm;
  };
  std::vector<Rectangle> rectangles_;
};

}  // namespace kerf
