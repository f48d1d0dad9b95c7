#include "window/hand_device.h"

#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

namespace kerf {

HandDeviceFrame HandDevice::Update(double dt_s, const ViewBasis& view, const Pose& X_WT, SawControls& controls) {
  HandDeviceFrame frame;
  frame.messages = servo_->TakeMessages();
  const ServoSample sample = servo_->TakeSample();
  const bool pressed = servo_->IsSpindlePressed(sample.sample.buttons);
  // The press that agrees to have force is none for the spindle.
  const bool engaged = sample.state == ServoState::kEngaged;
  frame.switches_spindle = engaged && engaged_ && pressed && !pressed_;
  pressed_ = pressed;
  engaged_ = engaged;

  const Quat R_WD = glm::normalize(glm::quat_cast(glm::dmat3(view.right_W, view.up_W, -view.forward_W)));
  if (holds()) {
    servo_->SetOrientation(R_WD);
    // Keys and mouse have its turning only.
    servo_->SetToolOrientation(controls.wanted().R_AB);
    controls.Set({controls.wanted().R_AB, X_WT.p_AB});
  } else if (sample.state == ServoState::kEngaged) {
    controls.Set(MoveByDeflection(controls.wanted(), sample.sample.deflection, R_WD, Vec3{0}, {}, dt_s));
  } else if (sample.state == ServoState::kWaiting) {
    servo_->Agree();  // no force comes of it
  }
  return frame;
}

}  // namespace kerf
