// What a simulated hand wants, from a scene's path: through the strokes, back out of the cut, over to the next, and
// from the beginning again.
#pragma once

#include <cstddef>
#include <limits>

#include "device/devices/simulated_device.h"
#include "loop/haptics/step_body.h"
#include "session/scene/path.h"
#include "session/scene/scene.h"

namespace kerf {

/// Strokes that go on from one another are one; the hand goes back the way it came before it sets down elsewhere. It
/// waits when the handle lags behind, at the end of a stroke too, and leans into what it feels along a stroke. Towards
/// its end it leans less, and stops there: neither handle nor tool goes beyond it. Deterministic.
class HandMotion final : public BeforeTick {
 public:
  /// The device must outlive it. `p_TC_mm`: the coupling's point, where the device holds the tool.
  /// `felt_stiffness_N_per_mm`: the coupling's, as the device feels it; by it the hand knows how far the tool is ahead
  /// of the handle. Above 0; infinite: the tool is where the handle is.
  HandMotion(SimulatedDevice& device, Path path, const SceneHand& hand, const Vec3& p_TC_mm,
             double felt_stiffness_N_per_mm = std::numeric_limits<double>::infinity());

  void Advance(double dt_s) noexcept override;
  /// Where it begins.
  Pose start() const { return path_.CalcPose(0, 0); }
  /// Times that it has been through the whole path; strokes begun. The loop's, or after its end.
  long rounds() const { return rounds_; }
  long strokes() const { return strokes_; }

 private:
  enum class Phase { kCut, kBack, kOver };
  void EnterNextChain() noexcept;
  double CalcSpeed(std::size_t segment) const;
  bool IsLastOfChain() const noexcept;
  double CalcWayLeft() const noexcept;
  double CalcStop(double left_mm) const noexcept;

  SimulatedDevice& device_;
  Path path_;
  SceneHand hand_;
  Vec3 p_TC_mm_;
  double felt_stiffness_N_per_mm_;
  Phase phase_ = Phase::kCut;
  std::size_t first_ = 0;    // segment of the chain
  std::size_t segment_ = 0;  // of it, now
  double t_s_ = 0;           // path time
  double waited_s_ = 0;      // at the end of a stroke
  double share_ = 0;         // of the way over
  Pose X_from_;              // of the way over
  Pose X_aim_;
  double pace_ = 0;  // 0 to 1: of the speed that it wants
  Vec3 push_W_N_{0};
  Vec3 way_W_{0};  // direction of the stroke, unit length
  long rounds_ = 0;
  long strokes_ = 1;
};

}  // namespace kerf
