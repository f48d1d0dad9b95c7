// One step of the tool against the leaves of the bone's grid: which of them it can change, and how it looks to them.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bone/leaf_table.h"
#include "kerf/geometry.h"
#include "removal/carve.h"

namespace kerf {

/// The tool's form, and the zone about its edge in which it changes phi; mm.
struct EdgeZone {
  bool ball = false;  // else a disc
  double radius_mm = 0;
  double half_thickness_mm = 0;  // of a disc
  double band_mm = 0;            // so far out of the tool
  double depth_mm = 0;           // and so far inside the edge; infinite where all of the tool cuts
};

/// Where the leaves of a grid lie in the tool's frame.
class LeafPlaces {
 public:
  LeafPlaces(const Pose& X_WT, double voxel_mm)
      : origin_T_(X_WT.InversePoint(Vec3(0))),
        grid_T_{X_WT.InverseVector({voxel_mm, 0, 0}), X_WT.InverseVector({0, voxel_mm, 0}),
                X_WT.InverseVector({0, 0, voxel_mm})},
        half_leaf2_mm2_(3 * 3.5 * 3.5 * voxel_mm * voxel_mm) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const Vec3& step_T : grid_T_) extent_[axis] += 3.5 * std::abs(step_T[axis]);
    }
  }

  /// One voxel along axis i of the grid.
  const Vec3& grid_T(int i) const { return grid_T_[i]; }
  /// A point given in voxels.
  Vec3 Point(double x, double y, double z) const {
    return origin_T_ + x * grid_T_[0] + y * grid_T_[1] + z * grid_T_[2];
  }
  Vec3 Corner(const LeafIndex& leaf) const { return Point(8.0 * leaf.x, 8.0 * leaf.y, 8.0 * leaf.z); }
  Vec3 Middle(const LeafIndex& leaf) const { return Point(8.0 * leaf.x + 3.5, 8.0 * leaf.y + 3.5, 8.0 * leaf.z + 3.5); }
  /// From a leaf's middle to its outermost voxel along a unit vector, and along the axes; mm.
  double Extent(const Vec3& e_T) const {
    return 3.5 * (std::abs(glm::dot(grid_T_[0], e_T)) + std::abs(glm::dot(grid_T_[1], e_T)) +
                  std::abs(glm::dot(grid_T_[2], e_T)));
  }
  const Vec3& extent() const { return extent_; }

  /// Whether some voxel of the leaf with this middle may lie within `slack_mm` of the zone. Never wrong when it says
  /// no.
  bool IsNear(const EdgeZone& zone, const Vec3& middle_T, double slack_mm) const {
    const double out_mm = zone.band_mm + slack_mm;
    Vec3 q = middle_T;
    if (!zone.ball) {
      if (std::abs(middle_T.z) - extent_.z > zone.half_thickness_mm + out_mm) return false;
      q.z = 0;
    }
    const double distance_mm = glm::length(q);
    if (distance_mm < 1e-9) return zone.radius_mm - zone.depth_mm - slack_mm <= std::sqrt(half_leaf2_mm2_);
    const double extent_mm = Extent(q / distance_mm);
    if (distance_mm - extent_mm > zone.radius_mm + out_mm) return false;
    // A voxel at s from the middle is at most distance + s.e + |s|^2 / (2 distance) from the axis.
    return distance_mm + extent_mm + half_leaf2_mm2_ / (2 * distance_mm) >= zone.radius_mm - zone.depth_mm - slack_mm;
  }

 private:
  Vec3 origin_T_;
  Vec3 grid_T_[3];
  Vec3 extent_{0};
  double half_leaf2_mm2_;
};

/// The sweep from X_from to X_to with the orientation of X_to. Of a disc the part of the way along its spindle is left
/// to the caller, who keeps it small by sub-steps.
struct Sweep {
  Sweep(const EdgeZone& the_zone, const Pose& X_from, const Pose& X_to, double voxel_mm, double flank_slack_mm,
        bool new_only, bool whole_voxels)
      : zone(the_zone), places(X_to, voxel_mm) {
    Vec3 back_T = X_to.InverseVector(X_from.p_AB - X_to.p_AB);
    if (!zone.ball) back_T.z = 0;
    length_mm = glm::length(back_T);
    back = length_mm > 0 ? back_T / length_mm : Vec3(0);

    step.ball = zone.ball;
    step.whole_voxels = whole_voxels;
    step.new_only = new_only;
    step.radius = static_cast<float>(zone.radius_mm);
    step.half_thickness = static_cast<float>(zone.half_thickness_mm);
    step.edge_depth = static_cast<float>(std::min(zone.depth_mm, 1e6));
    step.length = static_cast<float>(length_mm);
    step.flank_slack = static_cast<float>(flank_slack_mm);
    step.band = static_cast<float>(zone.band_mm);
    step.voxel = static_cast<float>(voxel_mm);
    step.rounding = static_cast<float>(1e-6 * (zone.radius_mm + 16 * voxel_mm) + 1e-4 * voxel_mm);
    for (int axis = 0; axis < 3; ++axis) {
      step.back[axis] = static_cast<float>(back[axis]);
      for (int i = 0; i < 3; ++i) step.grid[i][axis] = static_cast<float>(places.grid_T(i)[axis]);
    }
  }

  /// Whether the step may change some voxel of a leaf. Never wrong when it says no.
  bool MayChange(const Vec3& middle_T) const {
    const double rounding = static_cast<double>(step.rounding);
    if (step.new_only && glm::dot(middle_T, back) - places.Extent(back) > length_mm + rounding) return false;
    EdgeZone swept = zone;
    if (step.new_only) {
      // Further in than this the step before has carved as far: the flats are nearer, or all is air.
      const double in_mm = zone.ball ? zone.band_mm : zone.half_thickness_mm + static_cast<double>(step.flank_slack);
      swept.depth_mm = std::min(zone.depth_mm, in_mm + length_mm + rounding);
    }
    return places.IsNear(swept, middle_T, length_mm + rounding);
  }

  EdgeZone zone;
  LeafPlaces places;
  Vec3 back{0};  // unit, from the end to the start, tool frame; zero when it does not move
  double length_mm = 0;
  CarveStep step;
};

}  // namespace kerf
