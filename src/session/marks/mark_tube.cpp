#include "session/marks/mark_tube.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "cut/tool/shape.h"
#include "session/marks/segment.h"

namespace kerf {
namespace {

constexpr double kNothing_mm = 1e9;
constexpr double kSearch_mm = 1e-4;

/// Returns the point of the segment nearest to the tool's body. The distance from a convex body is a convex function
/// along a line, so the interval with the minimum can be narrowed by the golden ratio. The function changes by at most
/// the distance moved, so the error is at most the length of the last interval.
Vec3 FindNearestToTool(const Tool& tool, const Vec3& a_T, const Vec3& b_T) {
  constexpr double kGolden = 0.6180339887498949;
  const auto at = [&](double f) { return a_T + f * (b_T - a_T); };
  const auto distance = [&](double f) { return CalcPassedDistance(tool, at(f)); };
  const double length_mm = glm::length(b_T - a_T);
  double low = 0;
  double high = 1;
  double f1 = high - kGolden;
  double f2 = low + kGolden;
  double d1 = distance(f1);
  double d2 = distance(f2);
  while ((high - low) * length_mm > kSearch_mm) {
    if (d1 < d2) {
      high = f2;
      f2 = f1;
      d2 = d1;
      f1 = high - kGolden * (high - low);
      d1 = distance(f1);
    } else {
      low = f1;
      f1 = f2;
      d1 = d2;
      f2 = low + kGolden * (high - low);
      d2 = distance(f2);
    }
  }
  double best = 0.5 * (low + high);
  for (const double end : {0.0, 1.0}) {
    if (distance(end) < distance(best)) best = end;
  }
  return at(best);
}

}  // namespace

MarkTube::MarkTube(const Mark& mark)
    : name_(mark.name), kind_(mark.kind), radius_mm_(mark.radius_mm), curve_W_(CalcCurve(mark.points_W)) {}

MarkTube::Nearest MarkTube::Find(const Tool& tool, const Pose& X_WT) const {
  Nearest best{.distance_mm = kNothing_mm};
  if (empty()) return best;
  const auto take = [&](const Vec3& p_T) {
    const double distance_mm = CalcPassedDistance(tool, p_T) - radius_mm_;
    if (distance_mm < best.distance_mm) best = {.distance_mm = distance_mm, .p_W = X_WT.Point(p_T)};
  };
  Vec3 a_T = X_WT.InversePoint(curve_W_.front());
  take(a_T);
  for (std::size_t i = 1; i < curve_W_.size(); ++i) {
    const Vec3 b_T = X_WT.InversePoint(curve_W_[i]);
    // No point of the segment is nearer than its middle minus half of its length.
    const double least_mm = CalcPassedDistance(tool, 0.5 * (a_T + b_T)) - 0.5 * glm::length(b_T - a_T) - radius_mm_;
    if (least_mm < best.distance_mm) take(FindNearestToTool(tool, a_T, b_T));
    a_T = b_T;
  }
  return best;
}

MarkTube::Nearest MarkTube::Find(const Vec3& p_W) const {
  Nearest best{.distance_mm = kNothing_mm};
  for (std::size_t i = 0; i < curve_W_.size(); ++i) {
    const Vec3 q = FindNearestOnSegment(p_W, curve_W_[i], curve_W_[std::min(i + 1, curve_W_.size() - 1)]);
    const double distance_mm = glm::length(p_W - q) - radius_mm_;
    if (distance_mm < best.distance_mm) best = {.distance_mm = distance_mm, .p_W = q};
  }
  return best;
}

std::vector<MarkTube> MakeMarkTubes(const std::vector<Mark>& marks) {
  return {marks.begin(), marks.end()};
}

}  // namespace kerf
