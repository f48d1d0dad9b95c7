// A curve in bounded memory: its extremes are kept, and all points are kept while it is short.
#include "base/core/thinned.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace kerf {
namespace {

struct Point {
  int first = 0;
  int count = 1;
  int largest = 0;
  static Point Merge(const Point& a, const Point& b) {
    return {a.first, a.count + b.count, std::max(a.largest, b.largest)};
  }
};

TEST(Thinned, KeepsAllPointsUntilFullAndThenTheExtremes) {
  Thinned<Point, 8> curve;
  curve.Reserve(1000);
  EXPECT_LE(curve.points().capacity(), 16U);
  const Point* const place = curve.points().data();
  for (int n = 1; n <= 1000; ++n) {
    curve.Add({n - 1, 1, n * 37 % 101});
    const auto& points = curve.points();
    ASSERT_LE(points.size(), 8U);
    ASSERT_EQ(points.data(), place);
    if (n < 8) {
      ASSERT_EQ(points.size(), static_cast<std::size_t>(n));
    }
    // The points' ranges follow each other without a gap, and each point has the largest value of its range.
    int next = 0;
    for (const Point& point : points) {
      ASSERT_EQ(point.first, next) << n;
      if (&point != &points.back()) {
        ASSERT_EQ(static_cast<std::size_t>(point.count), curve.each());
      }
      int largest = 0;
      for (int i = next; i < next + point.count; ++i) largest = std::max(largest, (i + 1) * 37 % 101);
      ASSERT_EQ(point.largest, largest);
      next += point.count;
    }
    ASSERT_EQ(next, n);
  }
}

}  // namespace
}  // namespace kerf
