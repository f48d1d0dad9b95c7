// Blocks and strokes for the tests of the reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "experiment/reference/reference.h"

namespace kerf::test {

inline constexpr double kE_MPa = 19300;
inline constexpr double kNu = 0.28;

/// Returns a block centred at the origin of B.
inline ExactSolid Block(const Pose& X_WB, const Vec3& size) {
  ExactSolid solid;
  solid.distance_mm = [=](const Vec3& p_W) {
    const Vec3 d = glm::abs(X_WB.InversePoint(p_W)) - 0.5 * size;
    return glm::length(glm::max(d, Vec3(0))) + std::min(std::max({d.x, d.y, d.z}), 0.0);
  };
  solid.material = [](const Vec3&) { return ExactSolid::Material{24, kE_MPa, kNu}; };
  return solid;
}

/// Returns bone below z = 0.
inline ExactSolid HalfSpace() {
  ExactSolid solid;
  solid.distance_mm = [](const Vec3& p_W) { return p_W.z; };
  solid.material = [](const Vec3&) { return ExactSolid::Material{24, kE_MPa, kNu}; };
  return solid;
}

/// Returns a pose with centre p, spindle along +y and tool x along x: the disc is upright in a plane of constant y.
inline Pose Upright(const Vec3& p) {
  return {glm::angleAxis(-std::numbers::pi / 2, Vec3(1, 0, 0)), p};
}

inline Pose Times(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.R_AB * X_BC.R_AB, X_AB.Point(X_BC.p_AB)};
}

/// Returns the pose at each tick of a straight stroke.
inline std::vector<Pose> Stroke(const Vec3& from, const Vec3& to, double feed_mm_per_s, double tick_s = 0.001) {
  const int ticks = static_cast<int>(std::ceil(glm::length(to - from) / (feed_mm_per_s * tick_s) - 1e-9));
  std::vector<Pose> poses;
  for (int i = 0; i <= ticks; ++i) poses.push_back(Upright(from + (static_cast<double>(i) / ticks) * (to - from)));
  return poses;
}
inline void Append(std::vector<Pose>& poses, const std::vector<Pose>& more) {
  poses.insert(poses.end(), more.begin() + 1, more.end());
}

inline double EStar(double E_MPa, double nu, const DiscSaw& saw) {
  return 1 / ((1 - saw.nu * saw.nu) / saw.E_MPa + (1 - nu * nu) / E_MPa);
}

/// Returns the area of the circular segment of height `depth`.
inline double SegmentArea(double R, double depth) {
  return R * R * std::acos((R - depth) / R) - (R - depth) * std::sqrt(2 * R * depth - depth * depth);
}

}  // namespace kerf::test
