// Intended motion of a simulated hand, from a scene's path: along a stroke, back out of the cut and to the start of the
// next stroke; after the last stroke, the path is repeated.
#pragma once

#include <cstddef>
#include <limits>

#include "device/devices/simulated_device.h"
#include "loop/haptics/step_body.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {

/// Time that the hand takes from where a recording ends to the path.
inline constexpr double kJoin_s = 2;

/// Simulated hand that follows a path. Strokes that follow one another without a retract are treated as one stroke (a
/// chain). After a stroke, the hand returns along the stroke before it moves to the next one. It waits if the handle
/// lags, also at the end of a stroke, and presses against the resistance along a stroke. Near the end of a stroke it
/// presses less and stops there: neither the handle nor the tool passes the end. Deterministic.
class HandMotion final : public HandDriver {
 public:
  /// `device` must outlive this object. `p_TC_mm`: the coupling's point, where the device holds the tool.
  /// `felt_stiffness_N_per_mm`: the coupling's stiffness as rendered on the device, from which the hand computes how
  /// far the tool is ahead of the handle. Above 0; infinite: the tool is at the handle.
  HandMotion(SimulatedDevice& device, Path path, const SceneHand& hand, const Vec3& p_TC_mm,
             double felt_stiffness_N_per_mm = std::numeric_limits<double>::infinity());

  void Advance(double dt_s) noexcept override;
  /// Puts the hand and the handle at X_WH, from where they move straight to the start of the path in kJoin_s. The
  /// strokes and passes are counted from 0.
  void JoinFrom(const Pose& X_WH);
  /// Initial pose.
  Pose start() const { return path_.CalcPose(0, 0); }
  /// These return the number of completed passes through the path, and the number of strokes begun. Call in the loop's
  /// thread, or after the loop has ended.
  long passes() const { return passes_; }
  long strokes() const { return strokes_; }

 private:
  enum class Phase { kCut, kReturn, kTransfer, kJoin };
  /// Moves along the stroke. Returns the force with which the hand presses.
  Vec3 AdvanceCut(double dt_s) noexcept;
  void AdvanceReturn(double dt_s) noexcept;
  /// Moves straight to the start of a stroke.
  void AdvanceToStroke(double dt_s) noexcept;
  void EnterNextChain() noexcept;
  double CalcSpeed(std::size_t segment) const;
  bool IsLastOfChain() const noexcept;
  double CalcDistanceLeft() const noexcept;
  double CalcStop(double left_mm) const noexcept;

  SimulatedDevice& device_;
  Path path_;
  SceneHand hand_;
  Vec3 p_TC_mm_;
  double felt_stiffness_N_per_mm_;
  Phase phase_ = Phase::kCut;
  std::size_t first_ = 0;    // first segment of the chain
  std::size_t segment_ = 0;  // current segment of the chain
  double t_s_ = 0;           // path time
  double waited_s_ = 0;      // at the end of a stroke
  double fraction_ = 0;      // fraction of the motion to the next stroke
  Pose X_from_;              // start of the motion to the next stroke
  Pose X_aim_;
  double pace_ = 0;  // 0 to 1: fraction of the intended speed
  Vec3 push_W_N_{0};
  Vec3 direction_W_{0};  // direction of the stroke, unit length
  long passes_ = 0;
  long strokes_ = 1;
};

}  // namespace kerf
