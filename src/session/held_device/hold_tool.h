// A scene's tool in the hand of a person, by a device that is really there.
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

/// As the scene's [device] says: scale, orientation, left hand.
DeviceServoOptions MakeServoOptions(const Scene& scene);

/// The scene with this device in [device]: its profile (DeviceServoOptions::profile, else that of its own name, else
/// what the scene says), scale, and how late its force is; its slew within the safety gate's. A table of profiles that
/// the scene names stays, and which of them it is. Throws Error when those figures ask for more force than the device
/// has.
void SetDevice(Scene& scene, const DeviceServo& servo);

/// `stop` gives up waiting for the handle (may be null); `say` is told what the user is to do. The servo must outlive
/// the loop.
LoopDevice HoldBy(DeviceServo& servo, const std::atomic<bool>* stop,
                  const std::function<void(const std::string&)>& say);

struct DeflectionSpeeds {
  double mm_per_s = 60;  // at the end of the cap's way
  double rad_per_s = 0.8;
};

/// A device that tells how far its cap is pushed moves a hand that is simulated, as a mouse does: bone holds it back.
class DeflectionHand final : public BeforeTick {
 public:
  /// All must outlive it.
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

/// The pose moved on by a deflection for dt_s: along and about the device's axes, the point p_TC_mm held when it turns.
Pose MoveByDeflection(const Pose& X_WH, const std::array<double, 6>& deflection, const Quat& R_WD, const Vec3& p_TC_mm,
                      const DeflectionSpeeds& speeds, double dt_s);

}  // namespace kerf
