// A device that is really there, as the window sees it: its messages, its buttons, and where its handle is seen from.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/saw_controls.h"
#include "session/held_device/hold_tool.h"
#include "view/live/hud.h"

namespace kerf {

/// What came of a frame.
struct HandDeviceFrame {
  std::vector<std::string> messages;
  bool switches_spindle = false;  // its button was pressed
};

/// The window's thread. With force it holds the saw, and keys and mouse turn it; without, it moves the saw as they do.
class HandDevice {
 public:
  explicit HandDevice(std::shared_ptr<DeviceServo> servo) : servo_(std::move(servo)) {}

  DeviceServo& servo() { return *servo_; }
  bool holds() const { return servo_->traits().makes_force; }
  /// The user has to say that the force may come back.
  bool waits() const { return servo_->state() == ServoState::kWaiting; }
  void Agree() { servo_->Agree(); }

  /// Once a frame. `X_WT`: the saw. Its right is the picture's right, whenever the handle takes the saw anew.
  HandDeviceFrame Update(double dt_s, const ViewBasis& view, const Pose& X_WT, SawControls& controls);
  /// Its buttons and keys, for the help.
  HudKeyGroup MakeHelp() const;
  /// Why there is no force, and what the user does about it; none while the device has the saw.
  std::optional<HudBanner> MakeBanner() const;

 private:
  std::shared_ptr<DeviceServo> servo_;
  // In the last frame.
  bool pressed_ = true;
  bool engaged_ = false;
  std::uint32_t engagements_ = 0;
  std::string told_;  // by the device, last
};

}  // namespace kerf
