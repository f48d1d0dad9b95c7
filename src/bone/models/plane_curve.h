// Smooth curve in a plane, parametrised by arc length, and its closest point to a given point.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bone/models/shapes.h"

namespace kerf {

/// Natural cubic spline through values at knots; straight beyond the ends. Evaluation is tick-safe.
class CubicSpline {
 public:
  CubicSpline() = default;
  /// `x`: strictly increasing, at least 2 values. `slope_zero_at_start`: for a curve that is mirrored at its start.
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

/// Position of a point relative to a curve.
struct CurvePlace {
  double s = 0;       // arc length of the closest point, mm, clamped to the curve
  double offset = 0;  // mm along the normal; positive to the right of the direction of travel
  double beyond = 0;  // mm past the end, or before the start, along the tangent (>= 0)
};

/// Curve through given points that starts on the y axis (x = 0) in the direction of +x, as half of a curve that is
/// mirrored there.
class PlaneCurve {
 public:
  PlaneCurve() = default;
  explicit PlaneCurve(const std::vector<Vec2>& points);

  double length() const { return length_; }
  Vec2 Point(double s) const { return Evaluate(s).point; }  // straight beyond the ends
  Vec2 Tangent(double s) const;                             // unit
  /// Returns the unit vector to the right of the tangent: outward for an arch that begins at the front.
  Vec2 Normal(double s) const;
  /// Finds the closest point of the curve. Exact except for rounding for points within about 25 mm of the curve;
  /// farther away, accurate to a few tenths of a mm.
  CurvePlace FindClosest(const Vec2& p) const;

 private:
  struct Terms {
    Vec2 point{0}, slope{0}, second{0};
  };
  Terms Evaluate(double s) const;
  double Refine(const Vec2& p, double s) const;  // closest point, from the initial guess `s`
  CurvePlace SearchClosest(const Vec2& p) const;

  std::uint64_t id_ = 0;  // of the curve and its copies
  double length_ = 0;
  // One cubic for each stretch of the curve. The stretches have nearly equal arc lengths: the knots are placed so that
  // |derivative| is 1 to within 1e-3.
  std::vector<std::array<Vec2, 4>> cubics_;
  double stretch_ = 1;
  // Closest point's s on a grid, used as the initial guess.
  Vec2 grid_origin_{0};
  double grid_step_ = 1;
  int grid_x_ = 0;
  int grid_y_ = 0;
  std::vector<float> guess_;
};

}  // namespace kerf
