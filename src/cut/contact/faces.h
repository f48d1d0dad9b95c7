// Contact of the faces of a tool that do not cut with the walls of what it has cut, which hold them: the flats of a
// blade in its kerf, the side of a drill in its hole.
#pragma once

#include <cstdint>
#include <vector>

#include "bone/grid/field.h"
#include "cut/contact/penetration_limiter.h"
#include "cut/contact/probe.h"
#include "cut/contact/step.h"
#include "cut/tool/shape.h"

namespace kerf {

/// Points on the faces, in pairs, one on each side of the tool.
///
/// The gap at a point is computed from a sample of the distance field that is taken a little inside the wall: the gap
/// is the sampled distance plus the sample's offset from the point. The sample is so far from the middle of the kerf,
/// where the distance field has a ridge, that no cell of the grid reaches from it across the ridge. Where the kerf is
/// locally narrower than the disc, the depths of both points of a pair are reduced by the same amount, so that the
/// walls hold the disc but never squeeze it.
class Faces {
 public:
  Faces(const BoneField& field, const ToolShape& shape, const Vec3& p_TC_mm);

  /// Returns the minimum distance of the outermost points from the rim, mm: slightly more than the depth to which the
  /// rim cuts the walls when it moves sideways (CutWith::kEdge). A kerf shallower than that cannot hold the flats.
  static double CalcRimMargin(double radius_mm, double voxel_mm) {
    return CalcToothSide(radius_mm, voxel_mm) + 0.25 * voxel_mm;
  }
  /// Returns the same distance for a stopped spindle. The rim then cuts nothing, so it is only the range over which the
  /// grid blurs the kerf's corner.
  static double CalcStoppedMargin(double voxel_mm) { return 1.75 * voxel_mm; }

  /// As Edge::SetDisplacement(). Tick-safe.
  void SetDisplacement(double slide_mm) {
    p_EC_ = motion_.Move(p_EC_, slide_mm_ - slide_mm);
    slide_mm_ = slide_mm;
  }

  /// Finds the points that are within `reach_mm` of bone. Fills problem.flats with those of a blade; appends others to
  /// problem.solids, with the stiffness of a flat. Tick-safe.
  void Find(const Probe& probe, double reach_mm, bool turning, StepProblem& problem);
  /// Returns the pair of an element of problem.flats, as filled by the last Find(). The two points of a pair are on
  /// opposite sides of the blade.
  std::size_t found_pair(std::size_t flat) const { return static_cast<std::size_t>(found_[flat].point / 2); }
  std::size_t pair_count() const { return pairs_.size(); }
  /// Position of a pair midway between its points, tool frame, mm.
  Vec3 pair_T(std::size_t pair) const { return pairs_[pair].middle_T; }
  /// As for Edge.
  double SetDepths(StepProblem& problem, bool may_rise);
  double Remember(const StepProblem& problem, const Twist& u, double fraction);
  /// Scales the deflection of all springs by `fraction`.
  void Ease(double fraction) { penetration_.Ease(fraction); }
  /// Sets all deflections to zero.
  void Release();
  /// Does what Release() does, and also discards the known distances: for use after the tool has been set down
  /// elsewhere or bone has been restored.
  void Forget();
  void set_stride(int stride) {
    if (stride != stride_) Release();  // the springs have changed
    stride_ = stride;
  }
  /// Number of samples of the bone so far.
  std::uint64_t samples() const { return samples_; }
  std::size_t size() const { return 2 * pairs_.size(); }

 private:
  struct Pair {
    Vec3 middle_T, n_T;  // tool frame, mm; the points are at middle -+ half_mm n
    double half_mm;
    bool while_stopped;
  };
  /// A pair that may have bone in reach, in a step.
  struct Seen {
    std::size_t pair;
    double cell_mm = 0;  // size of a cell of the grid along the normal
    double in_mm = 0;    // from the face to the sample inside the wall
    double depth_mm[2] = {};
  };
  void SetDepthsOfSeen(double reach_mm);

  bool are_flats_ = true;  // of a blade
  double slack_mm_;        // clearance added on each side
  double voxel_mm_;
  double tool_reach_mm_;
  Vec3 p_EC_;  // E: frame that moves with the blade
  EdgeMotion motion_;
  double slide_mm_ = 0;
  int stride_ = 1;
  std::vector<Pair> pairs_;
  PenetrationLimiter penetration_;
  std::vector<double> clear_until_mm_;  // for each pair: it has no bone in reach while travelled_mm_ is below this
  Pose X_looked_;
  double travelled_mm_ = 0;  // sum of the bounds on travel since the last Forget()
  std::vector<Seen> seen_;
  PointList list_;
  std::uint64_t samples_ = 0;
  std::vector<double> sampled_;
  struct Found {
    int point;
    double depth_mm;
  };
  std::vector<Found> found_;  // parallel to StepProblem::flats, or to the solids from first_solid_
  std::size_t first_solid_ = 0;
};

}  // namespace kerf
