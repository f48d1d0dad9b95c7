#include "app/window/hand_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat3x3.hpp>

#include "view/ui/translate.h"

namespace kerf {

HandDeviceFrame HandDevice::Update(double dt_s, const ViewBasis& view, const Pose& X_WT, SawControls& controls) {
  HandDeviceFrame frame;
  for (const std::string& message : servo_->TakeMessages()) frame.messages.push_back(TrReport(message));
  if (!frame.messages.empty()) reported_ = frame.messages.back();
  const ServoSample sample = servo_->TakeSample();
  engagements_ = sample.engagements;
  const bool pressed = servo_->IsSpindlePressed(sample.sample.buttons);
  // The press of a button that confirms the force does not also switch the spindle.
  const bool engaged = sample.state == ServoState::kEngaged;
  frame.switches_spindle = engaged && engaged_ && pressed && !pressed_;
  pressed_ = pressed;
  engaged_ = engaged;

  const Quat R_WD = glm::normalize(glm::quat_cast(glm::dmat3(view.right_W, view.up_W, -view.forward_W)));
  if (holds()) {
    if (servo_->options().reported_orientation) servo_->SetOrientation(R_WD);
    // Keys and mouse only turn the saw.
    servo_->SetToolOrientation(controls.wanted().R_AB);
    controls.Set({controls.wanted().R_AB, X_WT.p_AB});
  } else if (sample.state == ServoState::kEngaged) {
    const bool deflected =
        std::any_of(sample.sample.deflection.begin(), sample.sample.deflection.end(), [](double d) { return d != 0; });
    if (deflected) {
      controls.Set(MoveByDeflection(controls.wanted(), sample.sample.deflection, R_WD, Vec3{0}, {}, dt_s));
    } else if (deflected_) {
      controls.Release();
    }
    deflected_ = deflected;
  } else if (sample.state == ServoState::kWaiting) {
    servo_->Agree();  // safe: the device outputs no force
  }
  return frame;
}

HudKeyGroup HandDevice::MakeHelp() const {
  HudKeyGroup help{fmt::format(fmt::runtime(Tr("Device: {}")), servo_->name()), {}};
  if (!holds()) {
    help.keys.push_back({Tr("cap"), Tr("moves and turns the saw")});
    return help;
  }
  const bool turns = servo_->traits().senses_orientation;
  help.keys.push_back({Tr("handle"), turns ? Tr("moves and turns the saw") : Tr("moves the saw; keys, mouse turn it")});
  const std::string clutch = servo_->clutch_button();
  if (!clutch.empty()) {
    help.keys.push_back(
        {fmt::format(fmt::runtime(Tr("{} button")), clutch), Tr("held: the handle moves without the saw")});
  }
  const std::string spindle = servo_->spindle_button();
  if (!spindle.empty()) {
    help.keys.push_back({fmt::format(fmt::runtime(Tr("{} button")), spindle), Tr("spindle on/off")});
  }
  if (servo_->traits().makes_force) help.keys.push_back({Tr("Enter"), Tr("restore the force after a loss")});
  return help;
}

std::optional<HudBanner> HandDevice::MakeBanner() const {
  if (!holds()) return std::nullopt;
  HudBanner banner;
  switch (servo_->state()) {
    case ServoState::kEngaged:
      return std::nullopt;
    case ServoState::kHoming:
      banner.text = servo_->traits().makes_force
                        ? fmt::format(fmt::runtime(Tr("{}: {}. There is no force until then")), servo_->name(),
                                      TrMade(DescribeHoming(servo_->traits())))
                        : fmt::format("{}: {}", servo_->name(), TrMade(DescribeHoming(servo_->traits())));
      break;
    case ServoState::kWaiting:
      banner.text =
          engagements_ > 0
              ? fmt::format(fmt::runtime(Tr("{} is connected again; no force until you confirm")), servo_->name())
              : fmt::format(fmt::runtime(Tr("{}: hold the handle still in the middle to control the saw")),
                            servo_->name());
      if (HasReportedZero(servo_->traits())) {
        banner.text = fmt::format("{}: {}", servo_->name(), TrMade(servo_->traits().homing));
      }
      banner.answers = servo_->traits().buttons.empty() ? Tr("Enter") : Tr("Enter, or a button of the device");
      break;
    case ServoState::kSilent:
    case ServoState::kClosed:
      banner.kind = HudBanner::Kind::kWarning;
      banner.text =
          reported_.empty() ? fmt::format(fmt::runtime(Tr("{} is gone: no force")), servo_->name()) : reported_;
      break;
  }
  return banner;
}

}  // namespace kerf
