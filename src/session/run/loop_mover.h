// Moves the tool of a running loop out of bone: after undo and redo, and when it is retracted.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "loop/haptics/bone_mirror.h"
#include "loop/haptics/haptic_loop.h"
#include "session/run/clear_pose.h"
#include "session/run/loop_undo.h"

namespace kerf {

/// Plane in which an effect of the scene guides a disc.
struct GuidedPlane {
  Vec3 p_W{0};
  Vec3 normal_W{0, 0, 1};  // of length 1
  double tolerance_mm = 0;
};

/// Call in the reader's thread.
class LoopMover final : public ToolMover {
 public:
  /// `can_move`: the loop's hand can be moved by the program. `period_s`: of the loop.
  LoopMover(const Tool& tool, const Pose& X_WT_start, double period_s, bool can_move);
  /// Call before the loop starts; both must outlive this object.
  void Connect(HapticLoop& loop, BoneMirror& mirror);
  /// Sets the plane that a disc stays in. It is not brought back to a pose from before it was turned into the plane:
  /// it keeps its attitude and leaves the bone along its own plane.
  void set_guide(const GuidedPlane& guide) { guide_ = guide; }
  /// Call with each tick, in order.
  void Take(const LoopTick& tick);

  bool can_move() const override { return can_move_; }
  Pose X_WT() const override { return X_WT_; }
  std::optional<std::vector<Pose>> FindReturn(const Pose& X_wanted) override;
  std::optional<std::vector<Pose>> FindRetraction(const std::optional<Pose>& X_to) override;
  double removed_mm3() const override { return removed_mm3_; }
  /// Returns the number of leaves received by these so far.
  std::size_t leaves_received() const { return leaves_received_; }

 private:
  std::vector<Pose> FindWayOut(const PhiSampler& phi, const Pose& X_WT) const;
  Pose FindNearestWayOut(const PhiSampler& phi, const Pose& X_WT) const;
  bool LeavesGuide(const Pose& X_wanted, const Pose& X_now) const;
  std::vector<Pose> FindWayInAir(const PhiSampler& phi, const Pose& X_from, const Pose& X_to) const;
  /// Receives the changes of the bone; returns false while some are missing.
  bool UpdateBone();

  Tool tool_;
  Pose X_WT_;
  double period_s_;
  bool can_move_;
  HapticLoop* loop_ = nullptr;
  BoneMirror* mirror_ = nullptr;
  std::optional<GuidedPlane> guide_;
  ToolTrail trail_;
  double removed_mm3_ = 0;
  std::size_t leaves_received_ = 0;
};

}  // namespace kerf
