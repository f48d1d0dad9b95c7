// Whether the handle of a device is held still, near the middle of its workspace.
#pragma once

#include "device/drivers/device_servo.h"

namespace kerf {

/// Who has just homed a device still moves it; and from the edge of its workspace there is no way to go.
class HandleAtRest {
 public:
  explicit HandleAtRest(const DeviceServo& servo)
      : reach_mm_(kMiddle * servo.profile().workspace_radius_mm / servo.options().motion_scale) {}

  /// True when it has been near the middle for a while, and in one place.
  bool Take(const ServoSample& sample);

 private:
  static constexpr double kMiddle = 0.5;  // of the workspace's radius
  static constexpr double kStill_mm = 2;
  static constexpr double kStill_s = 0.5;
  static constexpr double kUnseen_s = 0.1;  // between samples: where it was meanwhile is unknown
  double reach_mm_;
  Vec3 place_D_mm_{1e9};
  double since_s_ = 0;
  double seen_s_ = 0;
};

}  // namespace kerf
