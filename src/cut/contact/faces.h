// The flats of a disc between the walls of its kerf: they do not cut, so the bone holds them.
#pragma once

#include <vector>

#include "bone/grid/field.h"
#include "cut/contact/probe.h"
#include "cut/contact/push_out.h"
#include "cut/contact/step.h"
#include "cut/tool/shape.h"

namespace kerf {

/// Points on both flats, in pairs, one on each side of the disc.
///
/// A point's gap is the distance a little inside the wall less that little: far enough from the middle of the kerf,
/// where distances have a ridge, that no cell of the grid reaches over it. Where the kerf is locally narrower than the
/// disc, both points of a pair are let out by the same: the walls hold the disc, they never squeeze it.
class Faces {
 public:
  Faces(const BoneField& field, const ToolShape& shape, const Tool& tool, const Vec3& p_TC_mm);

  /// How far inside the rim the outermost points must lie: a little further than what the rim cuts of the walls when it
  /// moves sideways (CutWith::kEdge). Shallower cuts than that have no hold on the flats.
  static double CalcRimMargin(double radius_mm, double voxel_mm) {
    return CalcToothSide(radius_mm, voxel_mm) + 0.25 * voxel_mm;
  }
  /// The same while the spindle stands still and the rim cuts nothing: as far as the grid blurs the kerf's corner.
  static double CalcStoppedMargin(double voxel_mm) { return 1.75 * voxel_mm; }

  /// Fills problem.flats with the points that bone is within `reach_mm` of. Tick-safe.
  void Find(const Probe& probe, double reach_mm, bool turning, StepProblem& problem);
  /// All of problem.flats are the last Find()'s; each is a point of a pair, one on each side of the disc.
  std::size_t found_pair(std::size_t flat) const { return static_cast<std::size_t>(found_[flat].point / 2); }
  std::size_t pair_count() const { return pairs_.size(); }
  /// In the disc's plane, tool frame, mm.
  Vec3 pair_T(std::size_t pair) const { return {pairs_[pair].x, pairs_[pair].y, 0}; }
  /// As Edge's.
  double SetDepths(StepProblem& problem, bool may_rise);
  double Remember(const StepProblem& problem, const Twist& u, double share);
  /// The springs are drawn by so much of what they were.
  void Ease(double share) { push_out_.Ease(share); }
  /// Nothing is borne any more.
  void Release();
  /// Nor is anything known of distances: the tool was moved elsewhere, or there is more bone than before.
  void Forget();
  void set_stride(int stride) {
    if (stride != stride_) Release();  // other springs
    stride_ = stride;
  }
  std::size_t size() const { return 2 * pairs_.size(); }

 private:
  struct Pair {
    double x, y;  // tool frame, mm
    bool while_stopped;
  };
  double half_mm_;
  double slack_mm_;  // let out on each side
  double voxel_mm_;
  double tool_reach_mm_;
  Vec3 p_TC_;
  int stride_ = 1;
  std::vector<Pair> pairs_;
  PushOut push_out_;
  std::vector<double> clear_until_mm_;  // travelled way up to which a pair surely has no bone near
  Pose X_looked_;
  double travelled_mm_ = 0;  // of the tool's fastest point
  struct Found {
    int point;
    double depth_mm;
  };
  std::vector<Found> found_;  // beside each of StepProblem::flats
};

}  // namespace kerf
