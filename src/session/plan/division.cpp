#include "session/plan/division.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kerf {

PlaneDivision::PlaneDivision(const std::vector<PlannedPlane>& planes) {
  for (const PlannedPlane& plane : planes) {
    rectangles_.push_back({.p_W = plane.plane.p_W,
                           .axes = CalcPlaneAxes(plane),
                           .half_width_mm = 0.5 * plane.width_mm,
                           .half_height_mm = 0.5 * plane.height_mm});
  }
}

int PlaneDivision::Find(const Vec3& p_W) const {
  if (rectangles_.empty()) return -1;
  return static_cast<int>(FindNearest(rectangles_.size(), [&](std::size_t i) {
    const Rectangle& r = rectangles_[i];
    const Vec3 d = p_W - r.p_W;
    const double across_mm = std::max(std::abs(glm::dot(d, r.axes.across_W)) - r.half_width_mm, 0.0);
    const double up_mm = std::max(std::abs(glm::dot(d, r.axes.up_W)) - r.half_height_mm, 0.0);
    const double off_mm = glm::dot(d, r.axes.normal_W);
    return across_mm * across_mm + up_mm * up_mm + off_mm * off_mm;  // mm2
  }));
}

}  // namespace kerf
