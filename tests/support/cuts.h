// Cuts with known answers for tests: a block in any pose, and strokes given in the block's own frame.
#pragma once

#include <numbers>
#include <vector>

#include "kerf/simulation.h"
#include "support/solids.h"

namespace kerf::test {

/// Returns poses of a block relative to the grid. In the first two, the disc's plane is on a layer of voxel centres and
/// midway between two layers, respectively. In the block's frame the disc lies in the plane y = 0.
inline std::vector<Pose> BlockPoses(double voxel_mm) {
  const auto turned = [](const Vec3& axis, double degrees, const Vec3& p) {
    Pose X;
    X.R_AB = glm::angleAxis(degrees * std::numbers::pi / 180, glm::normalize(axis));
    X.p_AB = p;
    return X;
  };
  return {
      Pose{},                                                   // disc on a layer
      turned({0, 0, 1}, 0, {0.011, 0.5 * voxel_mm, 0.037}),     // midway between layers
      turned({0, 0, 1}, 90, {0.25 * voxel_mm, 0.013, -0.021}),  // a quarter turn
      turned({0, 0, 1}, 45, {0.3, 0.1, 0.02}),                  // diagonal in a layer
      turned({1, 0, 0}, 30, {-0.07, 0.05, 0.013}),              // tilted
      turned({1, 1, 1}, 37, {0.123, 0.456, 0.789}),             // skew
      turned({1, -2, 0.5}, 71, {-0.31, 0.17, 0.23}),            // skew
      turned({0.3, 0.2, 1}, 26.565, {0.05, 0.02, 0.07}),        // near a rational direction
  };
}

/// Returns the pose of a disc in the block's frame: centre p_B, spindle along the block's +y, tool x along the block's
/// x.
inline Pose DiscPose(const Pose& X_WB, const Vec3& p_B) {
  // Columns of R_BT: x_T = x_B, y_T = -z_B, z_T = y_B.
  const Quat R_BT = glm::angleAxis(-std::numbers::pi / 2, Vec3(1, 0, 0));
  return {X_WB.R_AB * R_BT, X_WB.Point(p_B)};
}

/// Moves the disc's centre from `from_B` to `to_B` at `feed_mm_per_s`, in ticks of 1 ms. Returns each tick's output.
inline std::vector<TickOutput> Stroke(Simulation& simulation, const Pose& X_WB, const Vec3& from_B, const Vec3& to_B,
                                      double feed_mm_per_s, double rpm = 7500) {
  const double duration_s = glm::length(to_B - from_B) / feed_mm_per_s;
  const int ticks = static_cast<int>(std::ceil(duration_s * 1000 - 1e-9));
  std::vector<TickOutput> out;
  out.reserve(ticks);
  for (int i = 1; i <= ticks; ++i) {
    TickInput in;
    in.X_WT = DiscPose(X_WB, from_B + (static_cast<double>(i) / ticks) * (to_B - from_B));
    in.dt_s = duration_s / ticks;
    in.rpm = rpm;
    out.push_back(simulation.Tick(in));
  }
  return out;
}

/// Returns the area of the circular segment of height `depth`: the part of a disc of radius R below the surface at that
/// depth.
inline double SegmentArea(double R, double depth) {
  return R * R * std::acos((R - depth) / R) - (R - depth) * std::sqrt(2 * R * depth - depth * depth);
}

}  // namespace kerf::test
