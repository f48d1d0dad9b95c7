// Connects a real device to a scene, so that the user holds the scene's tool.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>

#include "device/drivers/device_servo.h"
#include "device/drivers/handle_at_rest.h"
#include "loop/haptics/loop_device.h"
#include "loop/haptics/mouse_hand.h"
#include "session/scene/scene.h"

namespace kerf {

/// Returns the options from the scene's [device]: scale, orientation, left hand.
DeviceServoOptions MakeServoOptions(const Scene& scene);

/// Sets the scene's [device] from this device: its profile (DeviceServoOptions::profile, otherwise the profile with
/// the device's name, otherwise the scene's), and scale and delay of its force. Limits its slew rate to the safety
/// gate's limit. A table of profiles that the scene names is kept, with the scene's choice from it. Throws kerf::Error
/// if the profile has a higher peak force than the device can output.
void SetDevice(Scene& scene, const DeviceServo& servo);

/// `stop` (optional) ends waiting for the handle. `say` is called with instructions for the user. `servo` must outlive
/// the loop.
LoopDevice HoldBy(DeviceServo& servo, const std::atomic<bool>* stop,
                  const std::function<void(const std::string&)>& say);

struct DeflectionSpeeds {
  double mm_per_s = 60;  // at full deflection of the cap
  double rad_per_s = 0.8;
};

/// Hand that is controlled by the deflection of a device's cap. It moves a simulated hand, as a mouse does, so the
/// bone resists it.
class DeflectionHand final : public HandDriver {
 public:
  /// All references must outlive this object.
  DeflectionHand(SimulatedDevice& device, DeviceServo& servo, const Quat& R_WD, const Vec3& p_TC_mm,
                 const DeflectionSpeeds& speeds = {});
  void Advance(double dt_s) noexcept override;

 private:
  DeviceServo& servo_;
  Quat R_WD_;
  Vec3 p_TC_mm_;
  DeflectionSpeeds speeds_;
  Pose X_WH_;
  HandTarget target_;
  MouseHand hand_;
};

/// Returns the pose moved by a deflection for `dt_s`: along and about the device's axes; the point `p_TC_mm` is fixed
/// in rotation.
Pose MoveByDeflection(const Pose& X_WH, const std::array<double, 6>& deflection, const Quat& R_WD, const Vec3& p_TC_mm,
                      const DeflectionSpeeds& speeds, double dt_s);

}  // namespace kerf
