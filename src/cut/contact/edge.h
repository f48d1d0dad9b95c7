// Contact of the cutting edge with the bone: finds the part of the edge that has bone in front of it, and the material
// of that bone. With the spindle stopped, the edge is a solid that rests on the bone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "bone/grid/field.h"
#include "cut/contact/engagement.h"
#include "cut/contact/met_material.h"
#include "cut/contact/penetration_limiter.h"
#include "cut/contact/probe.h"
#include "cut/contact/step.h"
#include "cut/tool/shape.h"

namespace kerf {

/// Distance in front of the edge at which a tooth looks for bone that was not cut, in voxels. On the edge itself it
/// would find none, because the surface of the cut lies exactly on the edge. A tooth that comes back to that surface is
/// engaged too early by this distance.
inline constexpr double kLookAheadVoxels = 0.05;
/// Depth over which a tooth enters the whole bone, in voxels: from half of it in front of the surface to half of it
/// behind, so that the length of an arc that crosses the surface is right. If teeth entered at once, a tool that slides
/// along the surface would lose all of them when it is lifted by a micrometre, and then nothing would hold it.
inline constexpr double kEntryVoxels = 0.15;
/// Distance in front of the edge at which the material is sampled, in voxels. If it were sampled further ahead, an arc
/// would reach the next tissue too early. If it were sampled on the edge itself, rounding would decide the tissue of a
/// tooth that runs along a border.
inline constexpr double kMaterialAheadVoxels = 0.05;

/// Sample points of the cutting edge, tested against the bone in each step.
class Edge {
 public:
  /// `p_TC_mm`: position of the coupling point C, to which the rows of the step refer. Allocates.
  Edge(const BoneField& field, const Bone& bone, const Tool& tool, const ToolShape& shape, const Vec3& p_TC_mm);

  /// Point of the edge that is in contact with bone. The list of these points is parallel to StepProblem::cutting.
  struct Contact {
    int region = 0;
    int point = 0;  // index in ToolShape::edge
  };

  /// Sets the displacement of an edge with a stroke. The poses of the probes and the points are from then on those of
  /// the frame E of the moved edge (EdgeMotion); the rows are of T, for the same coupling point as before. Tick-safe.
  void SetDisplacement(double slide_mm);

  /// Fills problem.cutting. Tick-safe.
  ///
  /// Model: the teeth are treated as continuous along the edge. A tooth is engaged where it is in the whole bone and
  /// there is bone in front of it that was not cut. Its engagement is 1 where nothing is cut as far as the look-ahead,
  /// 0 where the look-ahead just reaches the end of the cut, and linear between. Each point of the edge gets its part
  /// of the engagement in the two adjacent intervals. Within an interval both fields are taken as linear; an interval
  /// is halved where the engagement changes most. A tooth enters the whole bone gradually (kEntryVoxels).
  ///
  /// Teeth do not cut metal: points in front of it are left out.
  void FindTeeth(const Probe& probe, StepProblem& problem);
  /// Returns true if FindTeeth() has left out a point in front of metal.
  bool met_metal() const { return met_metal_; }
  const std::vector<Contact>& contacts() const { return contacts_; }

  /// Fills problem.solids with the points of a stopped edge. `reach_mm`: upper bound on a point's motion in this step.
  /// Tick-safe.
  void FindSolids(const Probe& probe, double reach_mm, double stiffness_N_per_mm, StepProblem& problem);
  /// The same for the points of a moving edge that are at metal, and for those that have no teeth and are not in the
  /// zone that the edge cuts (ToolShape::solids). Call after FindTeeth(), if needs_solids(). Tick-safe.
  void FindSolidsWhileCutting(const Probe& probe, double reach_mm, double stiffness_N_per_mm, StepProblem& problem);
  bool needs_solids() const { return has_metal_ || tooth_points_ < points_.size(); }
  /// Returns whether an element of problem.solids is a point of the cutting edge.
  bool is_tooth(std::size_t solid) const { return static_cast<std::size_t>(found_[solid].point) < tooth_points_; }
  double slide_mm() const { return slide_mm_; }
  const EdgeMotion& motion() const { return motion_; }
  /// Returns the tool frame's vector, or point, of one of E.
  Vec3 Turn(const Vec3& v_E) const { return motion_.is_straight() ? v_E : R_TE_ * v_E; }
  Vec3 Move(const Vec3& p_E) const { return motion_.Move(p_E, slide_mm_); }
  /// Number of elements of problem.solids that are points of the edge; they come first.
  std::size_t found_count() const { return found_.size(); }
  int found_point(std::size_t solid) const { return found_[solid].point; }
  const Vec3& point_T(std::size_t point) const { return points_[point].p_T; }
  /// Returns the position of a contact's point relative to the coupling point, tool frame.
  Vec3 Lever(const Contact& contact) const {
    return Turn(points_[static_cast<std::size_t>(contact.point)].p_T - p_EC_);
  }
  /// Sets the depths of the solids (see PenetrationLimiter). Returns the energy of their springs, N mm. Tick-safe.
  double SetDepths(StepProblem& problem, bool may_rise);
  /// Stores the depths of the solids after the given fraction of the step, for the next step. Returns the energy of
  /// their springs, N mm. Tick-safe.
  double Remember(const StepProblem& problem, const Twist& u, double fraction);
  /// Scales the deflection of all springs by `fraction`.
  void Ease(double fraction) { penetration_.Ease(fraction); }
  /// Sets all deflections to zero.
  void Release();
  /// Does what Release() does, and also discards the known distances: for use after the tool has been set down
  /// elsewhere or bone has been restored.
  void Forget();

  /// Uses every `stride`-th point, each with the weight of `stride` points: less accurate, but faster. Tick-safe.
  void set_stride(int stride) {
    if (stride != stride_) Release();  // the springs have changed
    stride_ = stride;
  }
  int stride() const { return stride_; }
  /// Number of samples of the bone so far.
  std::uint64_t samples() const { return samples_; }
  std::size_t size() const { return points_.size(); }

 private:
  struct Point {
    Vec3 ahead_T;
    Vec3 e_T;
    Vec3 p_T;
    double teeth;
    Twist along;                            // rings only
    double mm_per_pass = 0;                 // way of the point from one tooth to the next
    Touching touching = Touching::kAlways;  // of a point without teeth
  };
  bool is_joined() const { return is_chain_ || ring_radius_mm_ > 0; }
  /// Returns a lower bound on the distance of a look-ahead point, from its last sample and the travel since then.
  double CalcBound(std::size_t i) const { return distance_[i] - kMaxGradient * (travelled_mm_ - looked_at_mm_[i]); }
  /// Returns the neighbour after a point of a ring or a row; the last point of a row itself.
  std::size_t NextOf(std::size_t i) const {
    const std::size_t next = i + static_cast<std::size_t>(stride_);
    return next < tooth_points_ ? next : is_chain_ ? i : 0;
  }
  Vec3 CalcMaterialPoint(std::size_t i) const { return points_[i].p_T + material_ahead_mm_ * points_[i].e_T; }
  void SetBounds();
  /// What is at a point of the edge, mm: phi of the whole bone at the point itself, and the cut in front of it.
  using Ahead = PhiPair;
  /// Returns the fraction of a tooth that has entered the whole bone.
  double CalcEntered(double whole_mm) const { return std::clamp(0.5 - whole_mm / entry_mm_, 0.0, 1.0); }
  /// Returns the distance from where teeth are engaged, or a lower bound on it.
  double CalcDistance(const Ahead& at) const { return std::max(at.whole_mm - 0.5 * entry_mm_, at.cut_mm); }
  void SampleParts(const Probe& probe, const PointList& points);
  void Look(const Probe& probe);
  /// A place in an interval between two points, 0 to 1, with what is there.
  struct Place {
    double t;
    Ahead at;
    double distance_mm;
    double engagement;  // of a tooth that has entered the whole bone
  };
  Place MakePlace(double t, const Ahead& at) const;
  struct Part {
    int interval;  // index of the point at its start
    Place a, b;
  };
  enum class Use : std::uint8_t { kNone, kWhole, kHalves };
  Use FindUse(const Part& part, int halvings) const;
  void FractionIntervals(const Probe& probe);
  void Fraction(const Probe& probe, std::span<const int> intervals);
  void AddHalf(const Part& part);
  void SumParts();
  /// Returns the region; 0 if there is no material.
  int FindMaterial(const Probe& probe, std::size_t i, unsigned reads, ToothCut& cut) const;
  template <typename Wanted>
  void SampleSolids(const Probe& probe, Wanted&& wanted);
  void AddSolids(const Probe& probe, double reach_mm, double stiffness_N_per_mm, StepProblem& problem);
  bool IsAtMetal(const Probe& probe, const Point& point) const;
  void DropPointsAtMetal(const Probe& probe, StepProblem& problem);
  OsteonShares CalcOsteonShares(const Probe& probe, std::size_t i) const;

  const BoneField& field_;
  MaterialLookup materials_;
  std::optional<Vec3> osteons_W_;  // their direction, if known
  Vec3 p_EC_;
  EdgeMotion motion_;
  double slide_mm_ = 0;
  Quat R_TE_{1, 0, 0, 0};
  double look_ahead_mm_;
  double entry_mm_;
  double deep_mm_;  // phi of the whole bone below which its surface is too far away to matter
  double material_ahead_mm_;
  double region_step_mm_;  // additional look-ahead where the coarse region grid has no material
  bool has_metal_;
  double reach_mm_;        // largest distance of a look-ahead point from the tool's origin
  double ring_radius_mm_;  // radius of the ring; 0: the edge is not a ring
  bool is_chain_;          // the points are a row
  double ring_step_rad_;   // angle between neighbouring points of a ring
  int stride_ = 1;
  std::vector<Point> points_;  // of the edge, then those without teeth
  std::size_t tooth_points_;   // number of the former
  double spacing_mm_ = 0;      // spacing of the look-ahead points of a ring or a row, rounded up
  Pose X_looked_;
  double travelled_mm_ = 0;             // sum of the bounds on travel since the last Forget()
  std::vector<FacePoint> held_;         // the last points, with Touching::kMoving, in T
  std::vector<double> distance_;        // distance of each look-ahead point when it was last sampled
  std::vector<double> looked_at_mm_;    // value of travelled_mm_ at that time
  std::vector<Ahead> ahead_;            // of each point that was looked at in this step
  std::vector<double> bound_;           // lower bound on the distance of each look-ahead point in this step
  std::vector<double> solid_distance_;  // distance of each point itself, where it may be a solid in this step
  std::vector<double> fraction_;      // engaged part of the two intervals next to each point, as a number of intervals
  std::vector<double> after_;         // part of fraction_ that lies in the interval to the next point
  std::vector<Part> parts_, halves_;  // of some intervals
  IntervalParts summed_;              // those that are not halved
  std::vector<Contact> contacts_;
  // Lists of points, by index, for the time of a step: to be looked at, with the interval after them, with engaged
  // teeth.
  std::vector<int> to_look_, intervals_, engaged_, near_surface_;
  PointList list_;
  std::uint64_t samples_ = 0;
  std::vector<double> sampled_, sampled_cut_;
  std::vector<std::uint8_t> uniform_regions_;
  std::vector<double> uniform_E_MPa_, uniform_E_star_MPa_;
  bool met_metal_ = false;
  PenetrationLimiter penetration_;
  struct Found {
    int point;
    double depth_mm;
  };
  std::vector<Found> found_;  // parallel to StepProblem::solids
};

}  // namespace kerf
