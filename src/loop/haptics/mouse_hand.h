// Hand that is controlled by a mouse. It pulls the handle of a simulated device towards the pose that the mouse sets,
// so that bone resists it as it would resist a real hand.
#pragma once

#include "base/core/triple_buffer.h"
#include "device/devices/simulated_device.h"
#include "loop/haptics/step_body.h"

namespace kerf {

/// Desired pose of the tool frame, passed from the window thread to the loop thread.
using HandTarget = TripleBuffer<Pose>;

struct MouseHandParams {
  // Parameters of the simulated hand: stiff enough to press a saw, soft enough to be held back by bone.
  double stiffness_N_per_mm = 0.6;
  double damping_Ns_per_mm = 0.02;
  double mass_kg = 0.2;
  double reach_mm = 14;            // maximum distance between target and handle; limits the pull
  double smooth_s = 0.04;          // time constant with which the hand follows the mouse
  double speed_mm_per_s = 120;     // maximum speed
  double turning_rad_per_s = 2.0;  // maximum angular speed
};

class MouseHand final : public HandDriver {
 public:
  /// `device` and `target` must outlive this object, which becomes the reader of `target`. The handle starts at `X_WH`.
  MouseHand(SimulatedDevice& device, HandTarget& target, const Pose& X_WH, const Vec3& p_TC_mm,
            const MouseHandParams& params = {});

  void Advance(double dt_s) noexcept override;

 private:
  SimulatedDevice& device_;
  HandTarget& target_;
  Vec3 p_TC_mm_;
  MouseHandParams params_;
  Pose X_wanted_;
  Pose X_aim_;
  Vec3 v_mm_per_s_{0};
};

}  // namespace kerf
