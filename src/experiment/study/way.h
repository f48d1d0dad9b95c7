// Motions for the built-in paths: smooth in time, like those of a hand.
#pragma once

#include <utility>
#include <vector>

namespace kerf {

/// A coordinate over time. Its speed is given at some times, the knots, and is linear between them, so the motion has
/// no kinks. After the last knot the speed is constant; before the first one the coordinate is.
class Way {
 public:
  struct Knot {
    double t_s;
    double speed;  // units of the coordinate per second
  };
  /// Makes a coordinate that stays at `start`, by default 0.
  Way() = default;
  explicit Way(double start) : start_(start) {}
  /// `knots`: at least one, times ascending from 0.
  Way(double start, std::vector<Knot> knots) : start_(start), knots_(std::move(knots)) {}

  double operator()(double t_s) const {
    double place = start_;
    for (std::size_t i = 0; i < knots_.size(); ++i) {
      const Knot& a = knots_[i];
      if (t_s <= a.t_s) break;
      const bool last = i + 1 == knots_.size();
      const double span = last ? t_s - a.t_s : knots_[i + 1].t_s - a.t_s;
      const double rate = last ? 0 : (knots_[i + 1].speed - a.speed) / span;
      const double dt = t_s - a.t_s < span ? t_s - a.t_s : span;
      place += (a.speed + 0.5 * rate * dt) * dt;
    }
    return place;
  }

 private:
  double start_ = 0;
  std::vector<Knot> knots_;
};

}  // namespace kerf
