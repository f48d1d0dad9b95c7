// Plane through a cloud of points, by its moments.
#pragma once

#include <optional>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

struct WeightedPoint {
  Vec3 p;
  double weight;
};

/// A plane and the spreads (standard deviations) of the points it was fitted to.
struct MomentFit {
  Vec3 p{0};             // centre of the points
  Vec3 normal{0, 0, 1};  // direction of the smallest spread, unit length
  Vec3 along{1, 0, 0};   // direction of the largest spread
  double thickness = 0;  // across the plane,
  double breadth = 0;    // smaller one in the plane,
  double length = 0;     // larger one in the plane
};

/// Fits the plane with the least mean square distance. Returns none if there are fewer than `min_points` points or if
/// the sum of their weights is not positive.
std::optional<MomentFit> FitMoments(const std::vector<WeightedPoint>& points, std::size_t min_points = 3);

}  // namespace kerf
