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

/// Sets the scene's [device] from this device: its profile (DeviceServoOptions::profile, otherwise the profile with the
/// device's name, otherwise the scene's), and the scale and delay of its force. Limits the slew rate to what the safety
/// gate accepts. If the scene names a table of profiles, the table and the scene's choice from it are kept, unless
/// DeviceServoOptions::profile is set. Throws kerf::Error if the profile has a higher peak force than the device can
/// output.
void SetDevice(Scene& scene, const DeviceServo& servo);

/// Returns a loop device through which the user holds the tool. `stop` (optional) ends the wait for the handle. `say`
/// is called with instructions for the user. `servo` must outlive the loop.
LoopDevice MakeLoopDevice(DeviceServo& servo, const std::atomic<bool>* stop,
                          const std::function<void(const std::string&)>& say);

struct DeflectionSpeeds {
  double mm_per_s = 60;  // at full deflection of the cap
  double rad_per_s = 0.8;
};

/// Hand that is controlled by the deflection of a device's cap. It moves a simulated hand, as a mouse does, so the bone
/// resists it.
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

/// Returns the pose moved by a deflection for `dt_s`: translated along and rotated about the device's axes. The
/// rotation leaves the point `p_TC_mm` in place.
Pose MoveByDeflection(const Pose& X_WH, const std::array<double, 6>& deflection, const Quat& R_WD, const Vec3& p_TC_mm,
                      const DeflectionSpeeds& speeds, double dt_s);

}  // namespace kerf
