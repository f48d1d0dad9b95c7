// One implicit step of a body under set-valued forces: a v + sum of f(v) = b, with f monotone and piecewise linear, and
// vertical where contact sticks. Solved exactly. Tick-safe.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace kerf {

/// Monotone graph with four corners, constant before the first and after the last. Corners of equal v form a jump.
struct MonotoneGraph {
  struct Corner {
    double v;
    double f;
  };
  std::array<Corner, 4> corners;  // both coordinates ascending

  /// The one-sided limits of f at v.
  double Below(double v) const { return Value<false>(v); }
  double Above(double v) const { return Value<true>(v); }

 private:
  template <bool above>
  double Value(double v) const {
    const auto passed = [v](const Corner& c) { return above ? c.v <= v : c.v < v; };
    if (!passed(corners[0])) return corners[0].f;
    for (std::size_t i = 1; i < corners.size(); ++i) {
      if (passed(corners[i])) continue;
      const Corner& a = corners[i - 1];
      const Corner& b = corners[i];
      return a.f + (b.f - a.f) * std::clamp((v - a.v) / (b.v - a.v), 0.0, 1.0);
    }
    return corners.back().f;
  }
};

/// Returns the v for which a v + sum of graphs(v) = b, for a > 0. It is unique, because the left side is strictly
/// increasing. If v is at a jump, `fraction` is set to the position of the sum in the jump, 0 to 1; otherwise to 0.
template <std::size_t n>
double SolveMonotone(double a, double b, const std::array<MonotoneGraph, n>& graphs, double* fraction) {
  std::array<double, 4 * n> knots;
  for (std::size_t g = 0; g < n; ++g) {
    for (std::size_t i = 0; i < 4; ++i) knots[4 * g + i] = graphs[g].corners[i].v;
  }
  if constexpr (n > 1) std::sort(knots.begin(), knots.end());
  *fraction = 0;
  double before_v = 0;
  double before_rest = 0;  // residual of the equation just above the previous knot
  bool has_before = false;
  for (const double v : knots) {
    double below = a * v - b;
    double above = below;
    for (const MonotoneGraph& graph : graphs) {
      below += graph.Below(v);
      above += graph.Above(v);
    }
    if (below > 0) {
      if (has_before) return before_v - before_rest * (v - before_v) / (below - before_rest);
      double level = 0;
      for (const MonotoneGraph& graph : graphs) level += graph.corners.front().f;
      return (b - level) / a;
    }
    if (above >= 0) {
      if (above > below) *fraction = -below / (above - below);
      return v;
    }
    before_v = v;
    before_rest = above;
    has_before = true;
  }
  double level = 0;
  for (const MonotoneGraph& graph : graphs) level += graph.corners.back().f;
  return (b - level) / a;
}

}  // namespace kerf
