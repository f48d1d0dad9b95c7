// The hand of somebody who has a mouse: it pulls the handle of a simulated device towards where the mouse wants it, so
// that bone holds it back as it would a hand.
#pragma once

#include "base/core/triple_buffer.h"
#include "device/devices/simulated_device.h"
#include "loop/haptics/step_body.h"

namespace kerf {

/// Where a person wants the tool frame. From the window's thread to the loop's.
using HandTarget = TripleBuffer<Pose>;

struct MouseHandParams {
  // Of the hand that it is taken for: firm enough to press a saw, soft enough to be held back.
  double stiffness_N_per_mm = 0.6;
  double damping_Ns_per_mm = 0.02;
  double mass_kg = 0.2;
  double reach_mm = 14;            // it wants the handle no further from where it is: the greatest pull
  double smooth_s = 0.04;          // time constant with which it follows the mouse
  double speed_mm_per_s = 120;     // at most
  double turning_rad_per_s = 2.0;  // at most
};

class MouseHand final : public BeforeTick {
 public:
  /// Both must outlive it; the target's reader is this from now on. The handle begins at `X_WH`.
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
