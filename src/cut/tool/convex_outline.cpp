#include "cut/tool/convex_outline.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

using Point = ConvexOutline::Point;

/// Twice the area of the triangle a, b, c; positive if it turns to the left.
double Turn(const Point& a, const Point& b, const Point& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

}  // namespace

ConvexOutline ConvexOutline::MakeHull(std::span<const Point> points, const Cutting& cutting) {
  constexpr std::size_t kMaxPoints = 2 * kMaxCorners;
  assert(points.size() <= kMaxPoints);
  std::array<Point, kMaxPoints> sorted{};
  const auto n = static_cast<int>(points.size());
  std::copy(points.begin(), points.end(), sorted.begin());
  std::sort(sorted.begin(), sorted.begin() + n,
            [](const Point& a, const Point& b) { return a.x != b.x ? a.x < b.x : a.y < b.y; });
  // Andrew's monotone chain: the lower side from left to right, then the upper side back. Exact signs, so that no point
  // is lost where several lie on a line but for rounding.
  std::array<Point, kMaxPoints + 1> chain{};
  std::size_t count = 0;
  const auto add = [&](const Point& p, std::size_t from) {
    while (count >= from + 2 && Turn(chain[count - 2], chain[count - 1], p) <= 0) --count;
    chain[count++] = p;
  };
  for (int i = 0; i < n; ++i) add(sorted[static_cast<std::size_t>(i)], 0);
  const std::size_t lower = count - 1;
  for (int i = n - 2; i >= 0; --i) add(sorted[static_cast<std::size_t>(i)], lower);
  // Corners that stand out by less than rounding are left out. The last one is the first again.
  double size = 0;
  for (int i = 0; i < n; ++i) {
    const Point& p = sorted[static_cast<std::size_t>(i)];
    size = std::max({size, std::abs(p.x), std::abs(p.y)});
  }
  const auto is_near = [&](const Point& p, const Point& q) { return std::hypot(p.x - q.x, p.y - q.y) <= 1e-9 * size; };
  std::size_t kept = 1;
  for (std::size_t i = 1; i < count; ++i) {
    const bool is_last = i + 1 == count;
    while (kept >= 2 && Turn(chain[kept - 2], chain[kept - 1], chain[i]) <= 1e-12 * size * size) --kept;
    if (!is_last && !is_near(chain[i], chain[kept - 1]) && !is_near(chain[i], chain[0])) chain[kept++] = chain[i];
  }
  ConvexOutline hull;
  hull.cutting_ = cutting;
  assert(kept <= kMaxCorners);
  hull.count_ = static_cast<int>(std::min<std::size_t>(kept, kMaxCorners));
  std::copy_n(chain.begin(), hull.count_, hull.corners_.begin());
  return hull;
}

ConvexOutline::Side ConvexOutline::side(int i) const {
  const Point& a = corner(i);
  const Point& b = corner(i + 1 < count_ ? i + 1 : 0);
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  const Point normal{(b.y - a.y) / length, (a.x - b.x) / length};
  return {normal, normal.x * a.x + normal.y * a.y};
}

Point ConvexOutline::FindNearestOnSide(int i, const Point& p) const {
  const Point& a = corner(i);
  const Point& b = corner(i + 1 < count_ ? i + 1 : 0);
  const double dx = b.x - a.x, dy = b.y - a.y;
  const double t = std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / (dx * dx + dy * dy), 0.0, 1.0);
  return {a.x + t * dx, a.y + t * dy};
}

double ConvexOutline::CalcSignedDistance(const Point& p) const {
  double most = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < count_; ++i) {
    const Side s = side(i);
    most = std::max(most, s.normal.x * p.x + s.normal.y * p.y - s.offset_mm);
  }
  if (most <= 0) return most;
  const Point nearest = FindNearest(p);
  return std::hypot(p.x - nearest.x, p.y - nearest.y);
}

Point ConvexOutline::FindNearest(const Point& p) const {
  bool inside = true;
  Point best = p;
  double best_mm = std::numeric_limits<double>::infinity();
  for (int i = 0; i < count_; ++i) {
    const Side s = side(i);
    inside = inside && s.normal.x * p.x + s.normal.y * p.y <= s.offset_mm;
    const Point q = FindNearestOnSide(i, p);
    const double mm = std::hypot(p.x - q.x, p.y - q.y);
    if (mm < best_mm) {
      best = q;
      best_mm = mm;
    }
  }
  return inside ? p : best;
}

}  // namespace kerf
