// A smooth curve in a plane, by arc length, with the closest point on it.
#pragma once

#include <array>
#include <vector>

#include "bone/models/shapes.h"

namespace kerf {

/// Values at knots joined by a natural cubic spline; straight on beyond the ends. Tick-safe once made.
class CubicSpline {
 public:
  CubicSpline() = default;
  /// `x` strictly increasing, at least 2. `slope_zero_at_start`: for what is mirrored there.
  CubicSpline(std::vector<double> x, std::vector<double> y, bool slope_zero_at_start = false);
  double Value(double x) const { return Evaluate(x).value; }
  double Slope(double x) const { return Evaluate(x).slope; }

  struct Terms {
    double value = 0;
    double slope = 0;
    double second = 0;  // derivative
  };
  Terms Evaluate(double x) const;

 private:
  std::vector<double> x_, y_, second_;
};

/// Where a point lies from a curve.
struct CurvePlace {
  double s = 0;       // arc length of the closest point, mm, clamped to the curve
  double offset = 0;  // mm along the normal; right of the direction of travel is positive
  double beyond = 0;  // mm past the end along the tangent (>= 0); past the start likewise
};

/// A curve through given points that starts at x = 0 across the y axis, going towards +x, as half of one that is
/// mirrored there.
class PlaneCurve {
 public:
  PlaneCurve() = default;
  explicit PlaneCurve(const std::vector<Vec2>& points);

  double length() const { return length_; }
  Vec2 Point(double s) const { return Evaluate(s).point; }  // straight on beyond the ends
  Vec2 Tangent(double s) const;                             // unit
  /// To the right of the tangent: outward for an arch that begins at the front.
  Vec2 Normal(double s) const;
  /// For points within about 25 mm of the curve to rounding; farther off to some tenths of a mm.
  CurvePlace FindClosest(const Vec2& p) const;

 private:
  struct Terms {
    Vec2 point{0}, slope{0}, second{0};
  };
  Terms Evaluate(double s) const;
  double Refine(const Vec2& p, double s) const;  // closest point from a guess

  double length_ = 0;
  // By arc length (nearly: the knots are placed so that |derivative| is 1 to 1e-3): a cubic for each stretch of equal
  // length.
  std::vector<std::array<Vec2, 4>> cubics_;
  double stretch_ = 1;
  // The closest point's s on a grid, as the first guess.
  Vec2 grid_origin_{0};
  double grid_step_ = 1;
  int grid_x_ = 0;
  int grid_y_ = 0;
  std::vector<float> guess_;
};

}  // namespace kerf
