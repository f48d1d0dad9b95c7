// Blocks and strokes for the reference's tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "experiment/reference/reference.h"

namespace kerf::test {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kE_MPa = 19300;
inline constexpr double kNu = 0.28;

/// A block about the origin of B.
inline ExactSolid Block(const Pose& X_WB, const Vec3& size) {
  ExactSolid solid;
  solid.distance_mm = [=](const Vec3& p_W) {
    const Vec3 d = glm::abs(X_WB.InversePoint(p_W)) - 0.5 * size;
    return glm::length(glm::max(d, Vec3(0))) + std::min(std::max({d.x, d.y, d.z}), 0.0);
  };
  solid.material = [](const Vec3&) { return ExactSolid::Material{24, kE_MPa, kNu}; };
  return solid;
}

/// Bone below z = 0.
inline ExactSolid HalfSpace() {
  ExactSolid solid;
  solid.distance_mm = [](const Vec3& p_W) { return p_W.z; };
  solid.material = [](const Vec3&) { return ExactSolid::Material{24, kE_MPa, kNu}; };
  return solid;
}

/// Centre p, spindle along +y, tool x along x: the disc stands upright in the plane y = 0.
inline Pose Upright(const Vec3& p) {
  return {glm::angleAxis(-kPi / 2, Vec3(1, 0, 0)), p};
}

inline Pose Times(const Pose& X_AB, const Pose& X_BC) {
  return {X_AB.R_AB * X_BC.R_AB, X_AB.Point(X_BC.p_AB)};
}

/// Poses from tick to tick.
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

/// Area of the circular segment of height `depth`.
inline double SegmentArea(double R, double depth) {
  return R * R * std::acos((R - depth) / R) - (R - depth) * std::sqrt(2 * R * depth - depth * depth);
}

}  // namespace kerf::test
