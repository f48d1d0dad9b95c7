// Hand that is controlled by a mouse. It pulls the handle of a simulated device towards the pose that the mouse sets,
// so that bone resists it as it would resist a real hand.
#pragma once

#include "base/core/triple_buffer.h"
#include "device/devices/simulated_device.h"
#include "loop/haptics/step_body.h"

namespace kerf {

/// Desired pose of the tool frame, and whether the hand is there to reach it.
struct HandAim {
  Pose X_WH = {};
  bool holds = true;  // false: the user has let go, so the hand pulls nothing
};

/// Passed from the window thread to the loop thread.
using HandTarget = TripleBuffer<HandAim>;

struct MouseHandParams {
  // Parameters of the simulated hand: stiff enough to press a saw, soft enough to be held back by bone.
  double stiffness_N_per_mm = 0.6;
  double damping_Ns_per_mm = 0.02;
  double mass_kg = 0.2;
  double reach_mm = 14;            // maximum distance between target and handle; limits the pull
  double smooth_s = 0.04;          // time constant with which the hand follows the mouse
  double speed_mm_per_s = 120;     // maximum speed
  double turning_rad_per_s = 2.0;  // maximum angular speed
  // After the user has let go:
  double coast_mm = 1;     // in air the hand completes at most this much of the motion, against the handle's friction
  double settle_s = 0.03;  // time for which the handle is kept at a tool that touches bone, until the force is zero
  // A wedged blade springs out of its kerf after that time, until friction in the kerf holds it, with a force on the
  // hand. Once the blade no longer turns, so that friction does not drive it, and rests, the handle is moved to it
  // again.
  double rest_s = 0.05;   // time without motion that counts as rest
  double rest_mm = 0.02;  // motion that does not count
  int max_settles = 20;   // number of times; friction is left with a fraction of the force each time
};

/// While the user holds the tool, the hand pulls it towards the target. When the user lets go of a tool that touches
/// bone, hand and handle are at once where the tool is, so that nothing pulls it, and hold it there. In air the hand
/// completes a short motion; if the tool then touches bone, the hand stops there as well.
class MouseHand final : public HandDriver {
 public:
  /// `device` and `target` must outlive this object, which becomes the reader of `target`. The handle starts at `X_WH`.
  MouseHand(SimulatedDevice& device, HandTarget& target, const Pose& X_WH, const Vec3& p_TC_mm,
            const MouseHandParams& params = {});

  void Advance(double dt_s) noexcept override;
  void Follow(const Pose& X_WT, bool touches, bool turns) noexcept override;
  bool can_place() const override { return true; }
  /// The hand stays there until the user lets go, if necessary, and takes the tool again.
  void Place(const Pose& X_WH) noexcept override;
  bool holds() const noexcept override { return holds_; }

 private:
  void TakeTarget() noexcept;
  bool ComesToRest(double dt_s) noexcept;
  void AdvanceTowardsTarget(double dt_s) noexcept;
  void HoldStill(const Pose& X_WH) noexcept;

  SimulatedDevice& device_;
  HandTarget& target_;
  Vec3 p_TC_mm_;
  MouseHandParams params_;
  Pose X_wanted_;
  Pose X_aim_;
  Vec3 v_mm_per_s_{0};
  bool holds_ = true;     // the user holds the tool
  bool placed_ = false;   // the user has not let go since Place()
  bool stopped_ = false;  // the user has let go, and the tool has touched bone since
  double settles_s_ = 0;  // time left in which the hand follows the tool
  int settles_ = 0;       // number of times that a resting tool was followed
  double rests_s_ = 0;    // time for which the tool has not moved
  Vec3 p_rest_W_{0};      // its place at the beginning of that time
  Pose X_WT_;             // of the tool, after the last tick
  bool touches_ = false;
  bool turns_ = false;  // the spindle
};

}  // namespace kerf
