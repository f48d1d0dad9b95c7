// Mapping from a device's handle to the world: motion scale, orientation, and the clutch, which makes every place
// reachable with a small workspace.
#pragma once

#include <cstdint>

#include "device/devices/driver.h"
#include "kerf/device.h"
#include "kerf/geometry.h"

namespace kerf {

/// Orientation of the device's frame for a user in front of a patient in the frame of a CT (LPS): the user's right is
/// the patient's left, up is towards the patient's head, and towards the user is anterior.
inline const Quat kFacingPatient{0.70710678118654752, 0.70710678118654752, 0, 0};

struct WorkspaceParams {
  double motion_scale = 1;
  Quat R_WD = kFacingPatient;  // orientation of the device's frame in the world
  Vec3 p_TC_mm{0};             // point of the tool that the handle holds: CouplingParams::p_TC_mm
  bool senses_orientation = false;
};

/// For all that have a motion scale: [device] of a scene, command-line options.
template <typename Params, typename V>
void DescribeMotion(Params& p, V&& visit) {
  visit("motion_scale", p.motion_scale, Range{0.02, 20}, "motion of the tool, in mm per mm of the device's handle");
}
template <typename V>
void Describe(WorkspaceParams& p, V&& visit) {
  DescribeMotion(p, visit);
}

/// Point C of the handle moves point C of the tool: p_WC = a_W + motion_scale R_WD (p_DC - a_D). The anchor is the pair
/// of points a_D and a_W, which coincided when it was last set. If the orientation is sensed, the tool rotates with the
/// handle relative to the anchor. Tick-safe except for the constructor.
class Workspace {
 public:
  /// Throws a kerf::Error that names a parameter that is out of range. The initial anchor maps the handle's zero pose
  /// to the world's.
  explicit Workspace(const WorkspaceParams& params);

  /// Sets the anchor: from now on, X_DH corresponds to X_WT. With `R_WD`, also sets the orientation of the device's
  /// frame.
  void Anchor(const Pose& X_DH, const Pose& X_WT);
  void Anchor(const Pose& X_DH, const Pose& X_WT, const Quat& R_WD);
  /// Returns the pose of the tool frame that the handle requests.
  Pose CalcToolPose(const Pose& X_DH) const;
  /// Returns the handle pose for which CalcToolPose() returns X_WT (only its position if the orientation is not
  /// sensed).
  Pose CalcHandlePose(const Pose& X_WT) const;
  Vec3 ToDevice(const Vec3& v_W) const { return glm::conjugate(params_.R_WD) * v_W; }
  Vec3 ToWorld(const Vec3& v_D) const { return params_.R_WD * v_D; }
  const WorkspaceParams& params() const { return params_; }

 private:
  WorkspaceParams params_;
  Vec3 anchor_D_mm_{0};
  Vec3 anchor_W_mm_{0};
  Quat R_DH_anchor_{1, 0, 0, 0};
  Quat R_WT_anchor_{1, 0, 0, 0};
};

/// Returns the profile as felt through a workspace: values per mm of the handle become values per mm of the tool.
/// Forces are unchanged.
DeviceProfile ScaleProfile(DeviceProfile profile, double motion_scale);

/// Returns the device's frame for a left-handed user: R_WD mirrored from right to left. Since a rotation cannot mirror,
/// the rotation from R_WD_straight to R_WD is mirrored instead: its components about the up axis and the axis
/// towards the user change sign.
Quat MirrorForLeftHand(const Quat& R_WD, const Quat& R_WD_straight = kFacingPatient);

/// Returns the buttons with the right one and the left one swapped.
std::uint32_t SwapButtons(std::uint32_t buttons, int right_bit, int left_bit);

}  // namespace kerf
