// Kerfs with known planes in blocks of any pose.
#pragma once

#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "bone/grid/grids.h"
#include "bone/models/block.h"
#include "support/cuts.h"
#include "support/solids.h"

namespace kerf::plan_test {

inline constexpr double kDegrees = kDegreesPerRad;

inline double CalcAngle(const Vec3& a, const Vec3& b) {
  return kDegrees * std::atan2(glm::length(glm::cross(a, b)), std::abs(glm::dot(a, b)));
}

/// Sets phi to max(phi, -distance to the solid).
inline void Subtract(Bone& bone, const std::function<double(const Vec3&)>& distance) {
  const double h = bone.voxel_mm();
  openvdb::FloatGrid& grid = *GridsOf(bone).phi;
  const double band = bone.band_mm();
  const Box3 box = bone.CalcBounds().Grown(4 * h);
  auto values = grid.getAccessor();
  const auto index = [h](double x) { return static_cast<int>(std::floor(x / h)); };
  for (int x = index(box.lower.x); x <= index(box.upper.x); ++x) {
    for (int y = index(box.lower.y); y <= index(box.upper.y); ++y) {
      for (int z = index(box.lower.z); z <= index(box.upper.z); ++z) {
        const double d = -distance(h * Vec3(x, y, z));
        if (d <= -band) continue;
        const openvdb::Coord at(x, y, z);
        const float old = values.getValue(at);
        const auto cut = static_cast<float>(std::min(d, band));
        if (cut > old) values.setValue(at, cut);
      }
    }
  }
  FinishLevelSet(grid);
}

/// Cuts a disc's kerf in the plane through p. The kerf is round, with radius R about p, or goes through everything by
/// default.
inline void CutKerf(Bone& bone, const CutPlane& plane, double width, double R = 1e9) {
  Subtract(bone, [=](const Vec3& p) {
    const double z = glm::dot(plane.normal_W, p - plane.p_W);
    const double r = glm::length(p - plane.p_W - z * plane.normal_W);
    return std::max(std::abs(z) - 0.5 * width, r - R);
  });
}

struct Draw {
  explicit Draw(unsigned seed) : random(seed) {}
  double In(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  Vec3 Direction() {
    std::normal_distribution<double> normal;
    return glm::normalize(Vec3(normal(random), normal(random), normal(random)));
  }
  Pose AnyPose() {
    Pose X;
    X.R_AB = glm::angleAxis(In(0, std::numbers::pi), Direction());
    X.p_AB = Vec3(In(-20, 20), In(-20, 20), In(-20, 20));
    return X;
  }
  std::mt19937 random;
};

inline BlockParams BlockAt(const Pose& X_WB, double voxel_mm) {
  BlockParams block;
  block.size_mm = {16, 10, 8};
  block.X_WB = X_WB;
  block.voxel_mm = voxel_mm;
  return block;
}

}  // namespace kerf::plan_test
