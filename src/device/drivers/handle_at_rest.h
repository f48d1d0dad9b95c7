// Detects that a device's handle is held still near the middle of its workspace.
#pragma once

#include "device/drivers/device_servo.h"

namespace kerf {

/// This is needed because the user's hand still moves the handle after homing, and because a handle at the edge of the
/// workspace has no room to move.
class HandleAtRest {
 public:
  explicit HandleAtRest(const DeviceServo& servo)
      : reach_mm_(kMiddle * servo.profile().workspace_radius_mm / servo.options().motion_scale) {}

  /// Returns true if the handle has stayed in one place near the middle for kStill_s.
  bool Update(const ServoSample& sample);

 private:
  static constexpr double kMiddle = 0.5;  // fraction of the workspace's radius
  static constexpr double kStill_mm = 2;
  static constexpr double kStill_s = 0.5;
  static constexpr double kUnseen_s = 0.1;  // longest gap between samples; during a longer one, the position is unknown
  double reach_mm_;
  Vec3 place_D_mm_{1e9};
  double since_s_ = 0;
  double seen_s_ = 0;
};

}  // namespace kerf
