#include "bone/models/plane_curve.h"

#include <limits>

#include "bone/models/recent_values.h"

namespace kerf {
namespace {

constexpr double kMargin_mm = 45;  // of the grid around the curve

}  // namespace

CubicSpline::CubicSpline(std::vector<double> x, std::vector<double> y, bool slope_zero_at_start)
    : x_(std::move(x)), y_(std::move(y)), second_(x_.size(), 0.0) {
  // The second derivatives are computed by Thomas's algorithm.
  const std::size_t n = x_.size();
  std::vector<double> upper(n, 0.0), right(n, 0.0);
  if (slope_zero_at_start) {
    upper[0] = 0.5;
    right[0] = 3 * (y_[1] - y_[0]) / ((x_[1] - x_[0]) * (x_[1] - x_[0]));
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h0 = x_[i] - x_[i - 1];
    const double h1 = x_[i + 1] - x_[i];
    const double rhs = 6 * ((y_[i + 1] - y_[i]) / h1 - (y_[i] - y_[i - 1]) / h0);
    const double pivot = 2 * (h0 + h1) - h0 * upper[i - 1];
    upper[i] = h1 / pivot;
    right[i] = (rhs - h0 * right[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 0;) second_[i] = right[i] - upper[i] * second_[i + 1];
}

CubicSpline::Terms CubicSpline::Evaluate(double x) const {
  const double inside = std::clamp(x, x_.front(), x_.back());
  const std::size_t i =
      static_cast<std::size_t>(std::upper_bound(x_.begin() + 1, x_.end() - 1, inside) - x_.begin()) - 1;
  const double h = x_[i + 1] - x_[i];
  const double b = (inside - x_[i]) / h;
  const double a = 1 - b;
  Terms t;
  t.slope = (y_[i + 1] - y_[i]) / h + ((1 - 3 * a * a) * second_[i] + (3 * b * b - 1) * second_[i + 1]) * h / 6;
  t.value = a * y_[i] + b * y_[i + 1] + ((a * a * a - a) * second_[i] + (b * b * b - b) * second_[i + 1]) * h * h / 6 +
            (x - inside) * t.slope;
  if (x == inside) t.second = a * second_[i] + b * second_[i + 1];
  return t;
}

PlaneCurve::PlaneCurve(const std::vector<Vec2>& points) : id_(MakeFunctionId()) {
  // The curve is first parametrised by chord length, then again by the resulting arc length, so that |derivative| is
  // close to 1.
  std::vector<double> s(points.size(), 0.0), x, y;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) s[i] = s[i - 1] + glm::distance(points[i], points[i - 1]);
    x.push_back(points[i].x);
    y.push_back(points[i].y);
  }
  CubicSpline spline_x(s, x);
  CubicSpline spline_y(s, y, true);
  constexpr int kFine = 2000;
  constexpr int kKnots = 60;
  for (int round = 0; round < 2; ++round) {
    const double end = s.back();
    std::vector<double> length(kFine + 1, 0.0);
    std::vector<Vec2> fine;
    for (int i = 0; i <= kFine; ++i) {
      const double u = end * i / kFine;
      fine.emplace_back(spline_x.Value(u), spline_y.Value(u));
      const auto n = static_cast<std::size_t>(i);
      if (i > 0) length[n] = length[n - 1] + glm::distance(fine[n], fine[n - 1]);
    }
    std::vector<double> new_s, new_x, new_y;
    std::size_t j = 0;
    for (int k = 0; k <= kKnots; ++k) {
      const double target = length.back() * k / kKnots;
      while (j + 2 < length.size() && length[j + 1] < target) ++j;
      const double t = std::clamp((target - length[j]) / (length[j + 1] - length[j]), 0.0, 1.0);
      new_s.push_back(target);
      new_x.push_back(Mix(fine[j].x, fine[j + 1].x, t));
      new_y.push_back(Mix(fine[j].y, fine[j + 1].y, t));
    }
    s = new_s;
    spline_x = CubicSpline(new_s, new_x);
    spline_y = CubicSpline(new_s, new_y, true);
  }
  length_ = s.back();
  stretch_ = length_ / kKnots;
  for (int k = 0; k < kKnots; ++k) {
    // Cubic defined by value, slope and second derivative at one end and the second derivative at the other.
    const CubicSpline::Terms x0 = spline_x.Evaluate(s[static_cast<std::size_t>(k)]);
    const CubicSpline::Terms y0 = spline_y.Evaluate(s[static_cast<std::size_t>(k)]);
    const double end = s[static_cast<std::size_t>(k) + 1];
    const Vec2 second{x0.second, y0.second};
    const Vec2 change = Vec2{spline_x.Evaluate(end).second, spline_y.Evaluate(end).second} - second;
    cubics_.push_back({Vec2{x0.value, y0.value}, Vec2{x0.slope, y0.slope}, 0.5 * second, change / (6 * stretch_)});
  }

  Vec2 lower{std::numeric_limits<double>::infinity()};
  Vec2 upper = -lower;
  std::vector<Vec2> samples;
  constexpr int kSamples = 400;
  for (int i = 0; i <= kSamples; ++i) {
    samples.push_back(Point(length_ * i / kSamples));
    lower = glm::min(lower, samples.back());
    upper = glm::max(upper, samples.back());
  }
  grid_origin_ = lower - kMargin_mm;
  grid_x_ = static_cast<int>((upper.x - lower.x + 2 * kMargin_mm) / grid_step_) + 2;
  grid_y_ = static_cast<int>((upper.y - lower.y + 2 * kMargin_mm) / grid_step_) + 2;
  guess_.reserve(static_cast<std::size_t>(grid_x_) * static_cast<std::size_t>(grid_y_));
  for (int j = 0; j < grid_y_; ++j) {
    for (int i = 0; i < grid_x_; ++i) {
      const Vec2 p = grid_origin_ + grid_step_ * Vec2(i, j);
      double best = std::numeric_limits<double>::infinity();
      int closest = 0;
      for (int k = 0; k <= kSamples; ++k) {
        const Vec2 d = p - samples[static_cast<std::size_t>(k)];
        const double d2 = glm::dot(d, d);
        if (d2 < best) best = d2, closest = k;
      }
      guess_.push_back(static_cast<float>(Refine(p, length_ * closest / kSamples)));
    }
  }
}

PlaneCurve::Terms PlaneCurve::Evaluate(double s) const {
  const double inside = std::clamp(s, 0.0, length_);
  const std::size_t i = std::min(static_cast<std::size_t>(inside / stretch_), cubics_.size() - 1);
  const double u = inside - stretch_ * static_cast<double>(i);
  const std::array<Vec2, 4>& c = cubics_[i];
  Terms t;
  t.second = 2.0 * c[2] + (6 * u) * c[3];
  t.slope = c[1] + u * (2.0 * c[2] + (3 * u) * c[3]);
  t.point = c[0] + u * (c[1] + u * (c[2] + u * c[3])) + (s - inside) * t.slope;
  return t;
}

Vec2 PlaneCurve::Tangent(double s) const {
  return glm::normalize(Evaluate(s).slope);
}

Vec2 PlaneCurve::Normal(double s) const {
  const Vec2 t = Tangent(s);
  return {t.y, -t.x};
}

double PlaneCurve::Refine(const Vec2& p, double s) const {
  // Newton's method for (p - c(s)) . c'(s) = 0; the slope is kept away from 0, which it reaches at the centre of
  // curvature.
  for (int step = 0; step < 4; ++step) {
    const Terms c = Evaluate(s);
    const Vec2 d = p - c.point;
    const double slope = glm::dot(c.slope, c.slope) - glm::dot(d, c.second);
    const double move = glm::dot(d, c.slope) / std::max(slope, 0.3);
    s = std::clamp(s + move, 0.0, length_);
    if (std::abs(move) < 3e-3) break;  // the remaining error is about the square of this
  }
  return s;
}

CurvePlace PlaneCurve::FindClosest(const Vec2& p) const {
  thread_local RecentValues<CurvePlace> recent;
  return recent.Get(id_, p, [&] { return SearchClosest(p); });
}

CurvePlace PlaneCurve::SearchClosest(const Vec2& p) const {
  const Vec2 g = (p - grid_origin_) / grid_step_;
  const double gx = std::clamp(g.x, 0.0, grid_x_ - 1.001);
  const double gy = std::clamp(g.y, 0.0, grid_y_ - 1.001);
  const int i = static_cast<int>(gx);
  const int j = static_cast<int>(gy);
  const float* row =
      &guess_[static_cast<std::size_t>(j) * static_cast<std::size_t>(grid_x_) + static_cast<std::size_t>(i)];
  const float* next = row + grid_x_;
  const double lower = Mix(static_cast<double>(row[0]), static_cast<double>(row[1]), gx - i);
  const double upper = Mix(static_cast<double>(next[0]), static_cast<double>(next[1]), gx - i);
  const double s = Refine(p, Mix(lower, upper, gy - j));
  const Terms c = Evaluate(s);
  const Vec2 t = glm::normalize(c.slope);
  const Vec2 d = p - c.point;
  CurvePlace place;
  place.s = s;
  place.offset = d.x * t.y - d.y * t.x;
  if (s >= length_) place.beyond = std::max(glm::dot(d, t), 0.0);
  if (s <= 0) place.beyond = std::max(-glm::dot(d, t), 0.0);
  return place;
}

}  // namespace kerf
