// Points on the solids that hold a tool, and which of them are in or near bone.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "bone/grid/field.h"
#include "cut/contact/probe.h"
#include "cut/contact/step.h"
#include "cut/proximity/box_tree.h"
#include "cut/tool/handpiece.h"
#include "kerf/geometry.h"
#include "kerf/tool.h"

namespace kerf {

/// Rings of points around the solids of MakeHolder(). All poses are in the field's frame F. The functions are
/// tick-safe, but for the constructor.
///
/// Neighbouring rings form parts. For each part, Embree finds a lower bound on the distance of the ball around it from
/// the boxes that contain the bone; for each point, the distance field gives one. Both decrease by the motion, so that
/// few are sought again in a step. The bone may only shrink; otherwise call Forget().
class HolderPoints {
 public:
  static constexpr std::size_t kMaxPoints = 1024;

  struct Point {
    Vec3 p_T;  // tool frame, mm
    Vec3 n_T;  // outwards, unit length
    bool hub;
  };
  /// Point and its distance from the bone, mm, negative inside.
  struct Found {
    int point;
    double distance_mm;
  };

  /// `spacing_mm`: largest distance between two rings, > 0; increased as far as kMaxPoints requires. Allocates.
  HolderPoints(const BoneField& field, const Tool& tool, double spacing_mm);

  /// Returns true if certainly no point comes near bone on a motion between two poses.
  bool IsClear(const Pose& X_FT_from, const Pose& X_FT_to);
  /// Returns the points that are at most `reach_mm` from bone, in their order; at most a voxel. Valid until the next
  /// call.
  std::span<const Found> Find(const Probe& probe, double reach_mm);
  /// Returns how far points may move before the next Find(), after the last one: those near bone by `step_mm`, others
  /// by their distance from it, and at least by `step_mm`, at most half a voxel. `p_TC_mm`: the limits' point C, tool
  /// frame.
  std::array<StepProblem::MotionLimit, 2> CalcLimits(const Vec3& p_TC_mm, double step_mm);
  /// Discards what is known of distances: after bone has been restored.
  void Forget();

  const std::vector<Point>& points() const { return points_; }
  std::size_t CalcMemoryBytes() const;

 private:
  struct Part {
    std::size_t begin, end;  // of its points
    Vec3 centre_T{0};
    double radius_mm = 0;
    double until_mm = 0;  // travel at which it may be near bone, or is sought again
    double clear_mm = 0;  // free travel when it was last sought
    bool near = true;
  };
  void AddBody(const HolderBody& body, double spacing_mm, double radii);
  void MakeParts();
  void MoveTo(const Pose& X_FT);
  bool IsNear(Part& part);
  void Seek(Part& part);

  BoxTree tree_;
  double margin_mm_;
  double step_mm_;  // travel after which a part near bone is sought again
  std::vector<Point> points_;
  std::vector<std::size_t> rings_;  // index of the first point of each
  std::vector<Part> parts_;
  double reach_mm_ = 0;  // of the points, from the tool's origin
  Pose X_FT_;
  double travelled_mm_ = 0;
  std::vector<double> clear_until_mm_;  // of each point
  PointList list_;
  std::vector<int> seen_;
  std::vector<double> sampled_mm_;
  std::vector<Found> found_;
};

}  // namespace kerf
