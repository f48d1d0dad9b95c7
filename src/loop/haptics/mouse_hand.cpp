#include "loop/haptics/mouse_hand.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

constexpr double kSettleSteps = 3;

}  // namespace

MouseHand::MouseHand(SimulatedDevice& device, HandTarget& target, const Pose& X_WH, const Vec3& p_TC_mm,
                     const MouseHandParams& params)
    : device_(device), target_(target), p_TC_mm_(p_TC_mm), params_(params), X_wanted_(X_WH), X_aim_(X_WH), X_WT_(X_WH) {
  HandModel hand = device.hand();
  hand.name = "mouse";
  hand.mass_kg = params.mass_kg;
  hand.stiffness_N_per_mm = params.stiffness_N_per_mm;
  hand.damping_Ns_per_mm = params.damping_Ns_per_mm;
  device.SetHand(hand);
}

void MouseHand::Follow(const Pose& X_WT, bool touches, bool turns) noexcept {
  X_WT_ = X_WT;
  touches_ = touches;
  turns_ = turns;
}

void MouseHand::Place(const Pose& X_WH) noexcept {
  device_.Place(X_WH);
  HoldStill(X_WH);
  placed_ = holds_;
  holds_ = false;
  stopped_ = true;
  settles_s_ = 0;
  X_WT_ = X_WH;
  touches_ = false;
}

void MouseHand::HoldStill(const Pose& X_WH) noexcept {
  X_wanted_ = X_aim_ = X_WH;
  v_mm_per_s_ = Vec3{0};
}

void MouseHand::TakeTarget() noexcept {
  if (!target_.Update() || !IsValid(target_.front().X_WH)) return;
  const HandAim& aim = target_.front();
  placed_ = placed_ && aim.holds;
  if (placed_) return;
  if (aim.holds) {
    X_wanted_ = aim.X_WH;
    stopped_ = false;
  } else if (holds_) {
    // The motion that was under way is completed if it is short and nothing is in its way.
    X_wanted_ = {X_aim_.R_AB, aim.X_WH.p_AB};
    const Vec3 lead = X_wanted_.Point(p_TC_mm_) - device_.p_WC_mm();
    const double distance = glm::length(lead);
    if (distance > params_.coast_mm) X_wanted_.p_AB -= (distance - params_.coast_mm) / distance * lead;
  }
  holds_ = aim.holds;
}

void MouseHand::AdvanceTowardsTarget(double dt_s) noexcept {
  // Rotation: turn towards the target, no faster than a hand.
  Quat R_wanted = X_wanted_.R_AB;
  if (glm::dot(X_aim_.R_AB, R_wanted) < 0) R_wanted = -R_wanted;
  const double angle = 2 * std::acos(std::clamp(glm::dot(X_aim_.R_AB, R_wanted), -1.0, 1.0));
  if (angle > 1e-9) {
    const double fraction = std::min({1.0, dt_s / params_.smooth_s, params_.turning_rad_per_s * dt_s / angle});
    X_aim_.R_AB = glm::normalize(glm::slerp(X_aim_.R_AB, R_wanted, fraction));
  }

  // Translation: a critically damped second-order lag, integrated implicitly so that it is stable for any time step.
  const double w = 2 / params_.smooth_s;
  const Vec3 error = X_wanted_.p_AB - X_aim_.p_AB;
  v_mm_per_s_ = (v_mm_per_s_ + dt_s * w * w * error) / (1 + 2 * w * dt_s + w * w * dt_s * dt_s);
  const double speed = glm::length(v_mm_per_s_);
  if (speed > params_.speed_mm_per_s) v_mm_per_s_ *= params_.speed_mm_per_s / speed;
  X_aim_.p_AB += dt_s * v_mm_per_s_;

  // If bone holds the handle back, the pull is limited: the aimed position stays within reach_mm of the handle, so that
  // it does not run far ahead and have to come back later.
  const Vec3 ahead = X_aim_.Point(p_TC_mm_) - device_.p_WC_mm();
  const double distance = glm::length(ahead);
  if (distance > params_.reach_mm) {
    const Vec3 along = ahead / distance;
    X_aim_.p_AB -= (distance - params_.reach_mm) * along;
    v_mm_per_s_ -= std::max(0.0, glm::dot(v_mm_per_s_, along)) * along;
  }
}

/// Returns true once a tool that friction holds has not moved for a while, so that its force can be let go.
bool MouseHand::ComesToRest(double dt_s) noexcept {
  if (turns_) settles_ = 0;
  const bool moved = glm::distance(X_WT_.p_AB, p_rest_W_) > params_.rest_mm;
  if (turns_ || !touches_ || moved || settles_ >= params_.max_settles) {
    p_rest_W_ = X_WT_.p_AB;
    rests_s_ = 0;
    return false;
  }
  rests_s_ += dt_s;
  if (rests_s_ < params_.rest_s) return false;
  rests_s_ = 0;
  return true;
}

void MouseHand::Advance(double dt_s) noexcept {
  if (!(dt_s > 0)) return;
  dt_s = std::min(dt_s, 0.1);
  TakeTarget();
  if (!holds_ && !stopped_ && touches_) {
    stopped_ = true;
    settles_s_ = params_.settle_s;
    settles_ = 0;
    HoldStill(X_WT_);
  } else if (!holds_ && stopped_ && settles_s_ <= 0 && ComesToRest(dt_s)) {
    settles_s_ = params_.settle_s;
    ++settles_;
    HoldStill(X_WT_);
  }
  if (stopped_ && settles_s_ > 0) {
    // A handle that was only released would swing beyond the tool. It is moved to the tool a few times, while the tool
    // relaxes. If it followed the tool all the time, the forces of bone and spindle would drive both along.
    const double part_s = params_.settle_s / kSettleSteps;
    const double left_s = settles_s_ - dt_s;
    if (std::floor(left_s / part_s) != std::floor(settles_s_ / part_s)) HoldStill(X_WT_);
    settles_s_ = left_s;
    return device_.Place(X_aim_);
  }
  AdvanceTowardsTarget(dt_s);
  device_.SetIntention({.X_WH = X_aim_, .v_W_mm_per_s = v_mm_per_s_, .push_W_N = Vec3{0}, .yield_s = 0});
}

}  // namespace kerf
