// The cutting edge against the bone: which of it has bone before it, and of what material; with the spindle stopped, a
// solid that rests on the bone.
#pragma once

#include <vector>

#include "bone/grid/field.h"
#include "cut/contact/met_material.h"
#include "cut/contact/probe.h"
#include "cut/contact/push_out.h"
#include "cut/contact/step.h"
#include "cut/tool/shape.h"

namespace kerf {

/// How far ahead of the edge a tooth looks for bone, as a share of the voxel's edge. The cut surface lies exactly on
/// the edge, so on it there is nothing to see. An engaged arc comes out too long by about look-ahead * (cos(alpha) -
/// 1/2) / sin(alpha) where the rim crosses the surface at angle alpha from its lowest point: 0.4 % at 1.1 mm depth and
/// 0.1 mm voxels.
inline constexpr double kLookAheadVoxels = 0.2;
/// The same for the material that it meets. Further ahead an arc comes to the next tissue too early; on the edge itself
/// rounding says which tissue a tooth meets that runs along a border.
inline constexpr double kMaterialAheadVoxels = 0.05;

class Edge {
 public:
  /// `p_TC_mm`: the coupling point, about which the step's rows are taken. Allocates.
  Edge(const BoneField& field, const Bone& bone, const Tool& tool, const ToolShape& shape, const Vec3& p_TC_mm);

  /// A point of the edge that meets bone, beside each of StepProblem::cutting.
  struct Met {
    int region = 0;
    int point = 0;  // of ToolShape::edge
    double E_MPa = 0;
  };

  /// Fills problem.cutting. Tick-safe.
  ///
  /// Model: teeth lie densely along the edge. Where the bone fills the look-ahead a tooth is engaged, where its surface
  /// is
  ///        reached not at all, linear between; each point of the edge gets its share of the intervals beside it,
  ///        within which the distance is taken as linear (halved where it changes most).
  void FindTeeth(const Probe& probe, StepProblem& problem);
  const std::vector<Met>& met() const { return met_; }

  /// Fills problem.solids: a stopped edge. `reach_mm`: how far a point may come in this step. Tick-safe.
  void FindSolids(const Probe& probe, double reach_mm, double stiffness_N_per_mm, StepProblem& problem);
  /// The first of problem.solids are these points of the edge.
  std::size_t found_count() const { return found_.size(); }
  int found_point(std::size_t solid) const { return found_[solid].point; }
  const Vec3& point_T(std::size_t point) const { return points_[point].p_T; }
  /// Sets the solids' depths; see PushOut. Returns the energy in their springs, N mm. Tick-safe.
  double SetDepths(StepProblem& problem, bool may_rise);
  /// Where the solids stand when `share` of the step has been made, for the next. Returns the energy in their springs.
  /// Tick-safe.
  double Remember(const StepProblem& problem, const Twist& u, double share);
  /// The springs are drawn by so much of what they were.
  void Ease(double share) { push_out_.Ease(share); }
  /// Nothing is borne any more.
  void Release();
  /// Nor is anything known of distances: the tool was set down elsewhere, or there is more bone than before.
  void Forget();

  /// Every `stride`-th point stands for as many: less exact, cheaper. Tick-safe.
  void set_stride(int stride) {
    if (stride != stride_) Release();  // other springs
    stride_ = stride;
  }
  int stride() const { return stride_; }
  std::size_t size() const { return points_.size(); }

 private:
  struct Point {
    Vec3 ahead_T;
    Vec3 e_T;
    Vec3 p_T;
    Twist row;
    double teeth;
    Twist along;  // of a ring
  };
  double CalcBound(std::size_t i) const;
  void Look(const Probe& probe, std::size_t i);
  void ShareInterval(const Probe& probe, std::size_t a, std::size_t b);
  void Share(const Probe& probe, const Point& a, const Point& b, double t_a, double d_a, double t_b, double d_b,
             int halvings, double& share_a, double& share_b) const;
  bool FindMaterial(const Probe& probe, std::size_t i, MaterialLookup::Material& material) const;

  const BoneField& field_;
  MaterialLookup materials_;
  Vec3 p_TC_;
  double look_ahead_mm_;
  double material_ahead_mm_;
  double region_step_mm_;  // how much further to look where the region grid is too coarse to have a material
  double reach_mm_;        // of the look-ahead points from the tool's origin
  double ring_radius_mm_;  // 0: not a ring
  double ring_step_rad_;   // from point to point of a ring
  int stride_ = 1;
  std::vector<Point> points_;
  double spacing_mm_ = 0;  // of a ring's look-ahead points, a little more
  Pose X_looked_;
  double travelled_mm_ = 0;           // by the tool's fastest point
  std::vector<double> distance_;      // of the look-ahead points,
  std::vector<double> looked_at_mm_;  // as they were when so much was travelled
  std::vector<double> share_;         // engaged intervals beside each
  std::vector<double> after_;         // of it, of the interval to the next
  std::vector<Met> met_;
  PushOut push_out_;
  struct Found {
    int point;
    double depth_mm;
  };
  std::vector<Found> found_;  // beside each of StepProblem::solids
};

}  // namespace kerf
