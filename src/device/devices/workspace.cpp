#include "device/devices/workspace.h"

#include <cmath>

#include "kerf/error.h"

namespace kerf {

Workspace::Workspace(const WorkspaceParams& params) : params_(params) {
  CheckParameters(params);
  if (!IsValid({params.R_WD, params.p_TC_mm})) throw Error("the device's orientation is not a unit quaternion");
}

void Workspace::Anchor(const Pose& X_DH, const Pose& X_WT) {
  anchor_D_mm_ = X_DH.p_AB;
  anchor_W_mm_ = X_WT.Point(params_.p_TC_mm);
  R_DH_anchor_ = X_DH.R_AB;
  R_WT_anchor_ = X_WT.R_AB;
}

void Workspace::Anchor(const Pose& X_DH, const Pose& X_WT, const Quat& R_WD) {
  params_.R_WD = R_WD;
  Anchor(X_DH, X_WT);
}

Pose Workspace::CalcToolPose(const Pose& X_DH) const {
  Pose X_WT;
  X_WT.R_AB = R_WT_anchor_;
  if (params_.senses_orientation) {
    const Quat turn_D = X_DH.R_AB * glm::conjugate(R_DH_anchor_);
    X_WT.R_AB = glm::normalize(params_.R_WD * turn_D * glm::conjugate(params_.R_WD) * R_WT_anchor_);
  }
  const Vec3 p_WC = anchor_W_mm_ + params_.motion_scale * (params_.R_WD * (X_DH.p_AB - anchor_D_mm_));
  X_WT.p_AB = p_WC - X_WT.R_AB * params_.p_TC_mm;
  return X_WT;
}

Pose Workspace::CalcHandlePose(const Pose& X_WT) const {
  Pose X_DH;
  X_DH.R_AB = R_DH_anchor_;
  if (params_.senses_orientation) {
    const Quat turn_W = X_WT.R_AB * glm::conjugate(R_WT_anchor_);
    X_DH.R_AB = glm::normalize(glm::conjugate(params_.R_WD) * turn_W * params_.R_WD * R_DH_anchor_);
  }
  X_DH.p_AB = anchor_D_mm_ + ToDevice(X_WT.Point(params_.p_TC_mm) - anchor_W_mm_) / params_.motion_scale;
  return X_DH;
}

DeviceProfile ScaleProfile(DeviceProfile profile, double motion_scale) {
  profile.max_stiffness_N_per_mm /= motion_scale;
  profile.max_damping_Ns_per_mm /= motion_scale;
  profile.own_damping_Ns_per_mm /= motion_scale;
  profile.mass_kg /= motion_scale;
  profile.resolution_mm *= motion_scale;
  profile.workspace_radius_mm *= motion_scale;
  return profile;
}

Quat MirrorForLeftHand(const Quat& R_WD, const Quat& R_WD_straight) {
  const Quat turn = glm::conjugate(R_WD_straight) * R_WD;
  // Mirrored in x: the rotation axis keeps its x component, and its other components change sign.
  return glm::normalize(R_WD_straight * Quat{turn.w, turn.x, -turn.y, -turn.z});
}

std::uint32_t SwapButtons(std::uint32_t buttons, int right_bit, int left_bit) {
  const std::uint32_t right = buttons >> right_bit & 1u;
  const std::uint32_t left = buttons >> left_bit & 1u;
  const std::uint32_t rest = buttons & ~(1u << right_bit | 1u << left_bit);
  return rest | right << left_bit | left << right_bit;
}

}  // namespace kerf
