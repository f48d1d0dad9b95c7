// Measures the left half of a mandible as a surgeon would, given only functions for bone and teeth.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>
#include <vector>

#include "bone/models/mandible.h"

namespace kerf::test {

using Vec2 = glm::dvec2;
/// Signed value of the bone without crowns: positive outside, negative inside.
using Field = std::function<double(const Vec3&)>;

/// Returns the point at which the field changes sign, between an inside and an outside point.
inline Vec3 FindCrossing(const Field& bone, Vec3 inside, Vec3 outside) {
  for (int i = 0; i < 40; ++i) {
    const Vec3 middle = 0.5 * (inside + outside);
    (bone(middle) < 0 ? inside : outside) = middle;
  }
  return 0.5 * (inside + outside);
}

/// Returns the distance from an inside point to the last point of the bone along `direction`, mm; at most `limit`.
inline double WalkOut(const Field& bone, const Vec3& from, const Vec3& direction, double limit = 40) {
  constexpr double kStep = 0.25;
  double s = 0;
  while (s < limit && bone(from + (s + kStep) * direction) < 0) s += kStep;
  return glm::distance(from, FindCrossing(bone, from + s * direction, from + (s + kStep) * direction));
}

/// Side view of the bone: for each (y, z), whether any point with x >= 0 is inside.
class SideView {
 public:
  explicit SideView(const Field& bone, double step = 0.4) : step_(step) {
    for (double y = kY0; y < kY1; y += step) {
      for (double z = kZ0; z < kZ1; z += step) {
        bool inside = false;
        for (double x = 0; x < 64 && !inside;) {
          const double f = bone({x, y, z});
          inside = f < 0;
          x += std::max(0.6, 0.6 * f);
        }
        if (inside) points_.push_back({y, z});
      }
    }
  }
  const std::vector<Vec2>& points() const { return points_; }
  double step() const { return step_; }

 private:
  static constexpr double kY0 = -8, kY1 = 105, kZ0 = -52, kZ1 = 55;
  double step_;
  std::vector<Vec2> points_;
};

struct MandibleMeasures {
  double base_slope_deg = 0;
  double gonial_angle_deg = 0;
  double ramus_height = 0, coronoid_height = 0, condyle_height = 0;  // heights above the base line
  double ramus_width = 0;
};

/// Measures the side view; the width is measured at `lingula_height` above the base line.
inline MandibleMeasures MeasureSide(const SideView& view, double lingula_height) {
  // The base line touches the chin and the angle from below.
  Vec2 chin{0}, angle{0};
  double slope = 0;
  for (int round = 0; round < 10; ++round) {
    double chin_low = 1e9, angle_low = 1e9;
    for (const Vec2& p : view.points()) {
      const double low = p.y - slope * p.x;
      if (p.x < 25 && low < chin_low) chin_low = low, chin = p;
      if (p.x > 50 && low < angle_low) angle_low = low, angle = p;
    }
    slope = (angle.y - chin.y) / (angle.x - chin.x);
  }
  const Vec2 along = glm::normalize(Vec2{1, slope});  // towards the back
  const Vec2 up{-along.y, along.x};
  const auto height = [&](const Vec2& p) { return glm::dot(p - chin, up) + 0.5 * view.step(); };

  // The back edge is the line that touches the ramus from behind, below the neck.
  Vec2 lower{0}, upper{0};
  Vec2 edge = up;
  for (int round = 0; round < 10; ++round) {
    const Vec2 behind{edge.y, -edge.x};
    double lower_back = -1e9, upper_back = -1e9;
    for (const Vec2& p : view.points()) {
      const double h = height(p);
      const double b = glm::dot(p, behind);
      if (h > 8 && h < 16 && b > lower_back) lower_back = b, lower = p;
      if (h > 33 && h < 41 && b > upper_back) upper_back = b, upper = p;
    }
    edge = glm::normalize(upper - lower);
  }
  MandibleMeasures m;
  m.base_slope_deg = std::atan(slope) * 180 / std::numbers::pi;
  m.gonial_angle_deg = std::acos(glm::dot(edge, -along)) * 180 / std::numbers::pi;
  const Vec2 forward{-edge.y, edge.x};
  const auto u = [&](const Vec2& p) { return glm::dot(p - lower, forward); };

  // Upper outline as a function of u: condyle, notch, coronoid.
  std::vector<double> top(60, -1e9);
  double front = -1e9, back = 1e9;
  // The width is measured perpendicular to the back edge, through the lingula, at the middle of the ramus.
  Vec2 middle{0};
  double best = 1e9;
  for (const Vec2& p : view.points()) {
    const double off = std::abs(height(p) - lingula_height) + std::abs(u(p) - 16);
    if (off < best) best = off, middle = p;
  }
  for (const Vec2& p : view.points()) {
    const double at = u(p);
    if (at > -4 && at < 55) {
      double& t = top[static_cast<std::size_t>(at + 4)];
      t = std::max(t, height(p));
    }
    if (std::abs(glm::dot(p - middle, edge)) < 0.75 * view.step())
      front = std::max(front, at), back = std::min(back, at);
  }
  m.ramus_width = front - back + view.step();
  m.condyle_height = *std::max_element(top.begin(), top.begin() + 14);
  m.coronoid_height = *std::max_element(top.begin() + 24, top.begin() + 46);
  m.ramus_height = *std::min_element(top.begin() + 12, top.begin() + 32);
  return m;
}

/// Returns the height of the bone in a vertical section: from its lowest to its highest point in the plane that
/// contains `at`, `out` and z.
inline double MeasureHeight(const Field& bone, const Vec3& at, const Vec3& out) {
  double low = 1e9, high = -1e9;
  for (double n = -11; n <= 11; n += 0.25) {
    for (double z = -60; z < 10; z += 0.1) {
      const Vec3 p = Vec3{at.x, at.y, 0} + n * out + Vec3{0, 0, z};
      if (bone(p) >= 0) continue;
      low = std::min(low, z);
      high = std::max(high, z);
    }
  }
  return high - low + 0.1;
}

/// Returns the largest x of the bone at points for which `where` returns true.
inline double MeasureReach(const Field& bone, const std::function<bool(const Vec3&)>& where) {
  double reach = 0;
  for (double y = 30; y < 105; y += 0.5) {
    for (double z = -50; z < 50; z += 0.5) {
      if (!where({0, y, z})) continue;
      for (double x = 75; x > reach; x -= 0.1) {
        if (bone({x, y, z}) < 0) {
          reach = x;
          break;
        }
      }
    }
  }
  return reach;
}

/// Returns the thickness of regions 1 to 31, inward from the surface that is found along `outward` from an inside
/// point.
inline double MeasureCortex(const Field& bone, const std::function<int(const Vec3&)>& region, const Vec3& inside,
                            const Vec3& outward) {
  const double to_surface = WalkOut(bone, inside, outward);
  const Vec3 surface = inside + to_surface * outward;
  double depth = 0.02;
  while (depth < 12) {
    const int id = region(surface - depth * outward);
    if (id < 1 || id > 31) break;
    depth += 0.02;
  }
  return depth;
}

}  // namespace kerf::test
