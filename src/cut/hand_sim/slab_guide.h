// The saw on the thin slab's law: when there is no time to look at the bone, the disc goes on in its own plane against
// a resistance that depends on its depth, and what it passed is removed later.
#pragma once

#include <algorithm>
#include <vector>

#include "cut/contact/step.h"
#include "kerf/paper.h"

namespace kerf {

/// Model: a stiff guide keeps the disc in the plane that it had at the start. Going deeper, along the direction in
/// which
///        the teeth cut then, meets F(h) = F_0 n(h) / n(h_0), with the paper's number of teeth n at depth h (cubed in
///        the reading as computed) and the thrust F_0 that there was: the law's shape at the size that was felt. Along
///        the slot it meets as much; coming out nothing. The law knows no feed: from kMostFeed times that at the start
///        on (kLeastRated at least), the force grows with the feed, or a harder push would go through at any speed.
class SlabGuide {
 public:
  SlabGuide(const DiscSaw& saw, const Vec3& p_TC_mm, PaperReading reading);

  bool active() const { return active_; }
  static constexpr double kMostFeed = 2;
  static constexpr double kLeastRated_mm_per_s = 5;

  /// `f_cut_T_N`: of the teeth on the tool; `teeth`: how many are engaged; `u`: the tool's motion. Tick-safe.
  void Begin(const Pose& X_WT, const Vec3& f_cut_T_N, double teeth, const Twist& u);
  void End() { active_ = false; }
  /// Along the direction of the cut, mm; below 0 the tool is out. Tick-safe.
  double CalcDepth(const Pose& X_WT) const;
  double CalcResistance(double depth_mm) const;

  /// Adds guide and resistance to a step, each `share` (0 to 1) of itself. Tick-safe.
  void AddTo(const Pose& X_WT, double share, StepProblem& problem) const;
  /// In the guide's springs, N mm. Tick-safe.
  double CalcEnergy(const Pose& X_WT, double share) const;
  /// Takes the tool's plane as the guide's, and where it is as no deeper than the wall. Tick-safe.
  void Anchor(const Pose& X_WT) {
    X_plane_ = X_WT;
    stopped_depth_mm_ = std::max(stopped_depth_mm_, CalcDepth(X_WT));
  }

  /// With the spindle stopped the saw goes no deeper than it is: a wall instead of a resistance. Tick-safe.
  void Stop(const Pose& X_WT) {
    if (!stopped_) stopped_depth_mm_ = CalcDepth(X_WT);
    stopped_ = true;
  }
  void Turn() { stopped_ = false; }
  bool stopped() const { return stopped_; }

 private:
  static constexpr int kPoints = 3;
  Vec3 Point(int i) const;
  double CalcOffset(const Pose& X_WT, int i) const;

  DiscSaw saw_;
  Vec3 p_TC_;
  PaperReading reading_;
  bool active_ = false;
  Pose X_plane_;
  Vec3 p_start_W_{0};
  Vec3 direction_W_{0};
  double start_depth_mm_ = 0;
  double start_force_N_ = 0;
  double start_law_ = 0;  // n, or its cube, at the start
  double rated_mm_per_s_ = kLeastRated_mm_per_s;
  bool stopped_ = false;
  double stopped_depth_mm_ = 0;
};

/// Poses that the tool passed without removing anything, at most so many: when there are more, every other is dropped.
class PassedPath {
 public:
  PassedPath();

  /// No stretch is waiting.
  bool empty() const { return next_ + 1 >= poses_.size(); }
  /// Not even a pose is kept.
  bool forgotten() const { return poses_.empty(); }
  void Forget();
  /// Notes where the tool is, when it is `spacing_mm` or more from the last. Tick-safe.
  void Record(const Pose& X_WT, double spacing_mm);
  /// The next stretch to remove, as long as one cut may be. False: there is none, and the path is forgotten. Tick-safe.
  bool Next(const Tool& tool, double voxel_mm, Pose& from, Pose& to);
  /// The stretch that Next() gave last could not be removed: it is the next again. Tick-safe.
  void PutBack();

 private:
  static constexpr std::size_t kMostPoses = 4096;
  std::vector<Pose> poses_;
  std::size_t next_ = 0;  // the stretch from here to the next pose is to be removed,
  double done_ = 0;       // but for this share of it
  double thinning_ = 1;   // of the spacing
  std::size_t last_next_ = 0;
  double last_done_ = 0;
};

}  // namespace kerf
