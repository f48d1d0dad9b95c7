#include "app/window/held_saw.h"

#include <algorithm>
#include <cmath>

#include "view/ui/translate.h"

namespace kerf {
namespace {

/// Angle between two orientations, rad.
double CalcAngle(const Quat& a, const Quat& b) {
  return 2 * std::acos(std::min(1.0, std::abs(glm::dot(a, b))));
}

/// Fraction of a force or distance from which on a component determines the cause.
constexpr double kMostly = 0.5;

bool PushesMostlyAlong(const Vec3& v, const Vec3& axis) {
  const double along = std::abs(glm::dot(v, axis));
  return along > 0 && along > kMostly * glm::length(v);
}

}  // namespace

bool WantsMotion(const HeldSawInput& in) {
  if (!in.holds) return false;
  return glm::distance(in.X_wanted.p_AB, in.X_WT.p_AB) > kHeldLead_mm ||
         CalcAngle(in.X_wanted.R_AB, in.X_WT.R_AB) > kHeldLead_rad || glm::length(in.coupled.f_H_W_N) > kHeldForce_N;
}

std::optional<HeldReason> DiagnoseHeldSaw(const HeldSawInput& in) {
  if (!WantsMotion(in)) return std::nullopt;
  const CoupledOutput& out = in.coupled;
  const double guide_N = in.guide_force_N.value_or(0);
  const double bone_N = glm::length(out.f_cut_W_N + out.f_face_W_N + out.f_friction_W_N);
  if (!(guide_N > 0) && !(bone_N > 0)) return std::nullopt;
  const Vec3 lead_W = in.X_wanted.p_AB - in.X_WT.p_AB;
  // The hand is pushed back against the direction in which it presses.
  const Vec3 pressed_W = glm::length(lead_W) > 0.5 ? lead_W : -out.f_H_W_N;
  if (guide_N > bone_N) {
    return PushesMostlyAlong(pressed_W, in.guide_normal_W) ? HeldReason::kGuidePlane : HeldReason::kGuideDepth;
  }
  if ((out.status & kCoupledLeavesUsedUp) != 0) return HeldReason::kNoMemory;
  if ((out.status & kCoupledTouchesMetal) != 0) return HeldReason::kMetal;
  if (IsBlade(in.tool)) {
    const Vec3 spindle = in.X_WT.Vector({0, 0, 1});
    // A rotation about the spindle is free; one about any other axis presses the flats against the walls.
    const Vec3 wanted_spindle = in.X_wanted.Vector({0, 0, 1});
    const double tilt = std::acos(std::clamp(glm::dot(spindle, wanted_spindle), -1.0, 1.0));
    if (PushesMostlyAlong(pressed_W, spindle) || tilt > kHeldLead_rad || PushesMostlyAlong(out.f_face_W_N, spindle)) {
      return HeldReason::kBinds;
    }
  }
  if (!in.spindle_on || (out.status & kCoupledSpindleStopped) != 0) return HeldReason::kSpindleOff;
  if ((out.status & kCoupledForceLimited) != 0) return HeldReason::kForceLimit;
  return out.engaged_teeth > 0 ? HeldReason::kFedTooFast : HeldReason::kNotCut;
}

const char* DescribeHeldReason(HeldReason reason) {
  switch (reason) {
    case HeldReason::kGuidePlane:
      return Msg("The guide holds the saw in the planned plane. Press G to switch the guide off.");
    case HeldReason::kGuideDepth:
      return Msg("The guide stops the saw at the planned depth. Press G to switch the guide off.");
    case HeldReason::kBinds:
      return Msg("The blade binds sideways: ease it back along its plane.");
    case HeldReason::kSpindleOff:
      return Msg("The spindle is off: start it with Space, or press R to take the saw out of the bone.");
    case HeldReason::kForceLimit:
      return Msg("The saw already presses with its greatest force: press less and let it cut.");
    case HeldReason::kFedTooFast:
      return Msg("You feed the saw faster than it can cut: press less and let it cut.");
    case HeldReason::kMetal:
      return Msg("Metal holds the saw: a bone saw does not cut implants and plates. Take it back and cut beside them.");
    case HeldReason::kNoMemory:
      return Msg("The saw waits for memory: hold it still for a moment.");
    case HeldReason::kNotCut:
      return Msg("Bone is in the way of a part of the saw that has no teeth: take the saw back and cut beside it.");
  }
  return "";
}

void HeldSawWatch::Update(double dt_s, const HeldSawInput& in) {
  const bool moved =
      glm::distance(in.X_WT.p_AB, X_from_.p_AB) > kMoved_mm || CalcAngle(in.X_WT.R_AB, X_from_.R_AB) > kMoved_rad;
  if (moved || !WantsMotion(in)) {
    X_from_ = in.X_WT;
    stands_s_ = 0;
    reason_.reset();
    return;
  }
  stands_s_ += dt_s;
  if (stands_s_ >= kHeldFor_s) reason_ = DiagnoseHeldSaw(in);
}

}  // namespace kerf
