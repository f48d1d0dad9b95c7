// Real device as used by the window: its messages, its buttons, and the orientation of its handle on the screen.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/window/saw_controls.h"
#include "session/held_device/hold_tool.h"
#include "view/ui/hud.h"

namespace kerf {

/// Result of a frame.
struct HandDeviceFrame {
  std::vector<std::string> messages;
  bool switches_spindle = false;  // the spindle button was pressed
};

/// Used only by the window's thread. A device that reports positions holds the saw, and keys and mouse turn the saw
/// unless it reports orientations too. A device that reports deflections moves the saw as keys and mouse do.
class HandDevice {
 public:
  explicit HandDevice(std::shared_ptr<DeviceServo> servo) : servo_(std::move(servo)) {}

  DeviceServo& servo() { return *servo_; }
  bool holds() const { return servo_->traits().holds_tool(); }
  /// Returns true if the user must confirm that the force may return.
  bool waits() const { return servo_->state() == ServoState::kWaiting; }
  void Agree() { servo_->Agree(); }

  /// Must be called once per frame. `X_WT`: pose of the saw. Each time the handle engages the saw, the handle's right
  /// is aligned with the picture's right.
  HandDeviceFrame Update(double dt_s, const ViewBasis& view, const Pose& X_WT, SawControls& controls);
  /// Returns the device's buttons and keys, for the help.
  HudKeyGroup MakeHelp() const;
  /// Returns why there is no force and what the user can do about it; nullopt while the device holds the saw.
  std::optional<HudBanner> MakeBanner() const;

 private:
  std::shared_ptr<DeviceServo> servo_;
  // State of the last frame.
  bool pressed_ = true;
  bool engaged_ = false;
  bool deflected_ = false;
  std::uint32_t engagements_ = 0;
  std::string reported_;  // last message of the device
};

}  // namespace kerf
