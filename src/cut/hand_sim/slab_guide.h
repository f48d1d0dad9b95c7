// The slab law for a saw coupled to a handle: when there is no time to read the bone, the disc moves in its own plane
// against a resistance that depends on its depth. The bone that it passed is removed later.
#pragma once

#include <algorithm>
#include <optional>
#include <vector>

#include "cut/contact/step.h"
#include "kerf/paper.h"

namespace kerf {

/// Model: a stiff guide keeps the disc in the plane that it had at the start. Depth is measured along the direction in
/// which the teeth were cutting at that time. The resistance to going deeper is F(h) = F_0 n(h) / n(h_0), with the
/// paper's number of teeth n at depth h (cubed in the as_computed reading) and the thrust F_0 at the start: it has the
/// shape of the law, scaled to the actual force. Along the kerf the resistance is the same; on the way out it is zero.
/// The law does not depend on the feed. Above kMaxFeed times the feed at the start (at least kMinRated_mm_per_s) the
/// force therefore grows in proportion to the feed; otherwise a push harder than the resistance would move the saw at
/// any speed.
class SlabGuide {
 public:
  SlabGuide(const Tool& tool, const Vec3& p_TC_mm, PaperReading reading);

  /// Returns true if the law exists for the tool: it is a disc.
  bool applies() const { return saw_.has_value(); }
  bool active() const { return active_; }
  static constexpr double kMaxFeed = 2;
  static constexpr double kMinRated_mm_per_s = 5;

  /// `f_cut_T_N`: force of the teeth on the tool; `teeth`: number of engaged teeth; `u`: motion of the tool. Tick-safe.
  void Begin(const Pose& X_WT, const Vec3& f_cut_T_N, double teeth, const Twist& u);
  void End() { active_ = false; }
  /// Depth along the direction of the cut, mm; below 0 the tool is out of the bone. Tick-safe.
  double CalcDepth(const Pose& X_WT) const;
  double CalcResistance(double depth_mm) const;

  /// Adds guide and resistance to a step, both scaled by `fraction`, 0 to 1. Tick-safe.
  void AddTo(const Pose& X_WT, double fraction, StepProblem& problem) const;
  /// Returns the energy of the guide's springs, N mm. Tick-safe.
  double CalcEnergy(const Pose& X_WT, double fraction) const;
  /// Moves the guide to the tool's plane, and the wall to at least the tool's depth. Tick-safe.
  void Anchor(const Pose& X_WT) {
    X_plane_ = X_WT;
    stopped_depth_mm_ = std::max(stopped_depth_mm_, CalcDepth(X_WT));
  }

  /// Replaces the resistance by a wall at the current depth, while the spindle is stopped. Tick-safe.
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

  std::optional<DiscSaw> saw_;
  Vec3 p_TC_;
  PaperReading reading_;
  bool active_ = false;
  Pose X_plane_;
  Vec3 p_start_W_{0};
  Vec3 direction_W_{0};
  double start_depth_mm_ = 0;
  double start_force_N_ = 0;
  double start_law_ = 0;  // n or n^3 at the start
  double rated_mm_per_s_ = kMinRated_mm_per_s;
  bool stopped_ = false;
  double stopped_depth_mm_ = 0;
};

/// Poses that the tool has passed without removing bone, at most kMaxPoses. When the list is full, every other pose is
/// dropped.
class PassedPath {
 public:
  PassedPath();

  /// Returns true if no segment is pending.
  bool empty() const { return next_ + 1 >= poses_.size(); }
  /// Returns true if no pose is stored.
  bool forgotten() const { return poses_.empty(); }
  void Forget();
  /// Records the tool's pose if it is at least `spacing_mm` from the last one. Tick-safe.
  void Record(const Pose& X_WT, double spacing_mm);
  /// Finds the next segment to remove, no longer than one cut may be. If there is none, discards the path and returns
  /// false. Tick-safe.
  bool Next(const Tool& tool, double voxel_mm, Pose& from, Pose& to);
  /// Makes the last result of Next() the next one again, because it could not be removed. Tick-safe.
  void PutBack();

 private:
  static constexpr std::size_t kMaxPoses = 4096;
  std::vector<Pose> poses_;
  std::size_t next_ = 0;  // pose at which the next segment to remove begins
  double done_ = 0;       // fraction of that segment that has been removed
  double thinning_ = 1;   // factor on the spacing
  std::size_t last_next_ = 0;
  double last_done_ = 0;
};

}  // namespace kerf
