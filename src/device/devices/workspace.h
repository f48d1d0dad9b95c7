// Where a device's handle is in the world: how far the tool goes for a way of the handle, which way is up, and the
// clutch, by which a small workspace reaches everywhere.
#pragma once

#include <cstdint>

#include "device/devices/device.h"
#include "device/devices/driver.h"
#include "kerf/geometry.h"

namespace kerf {

/// The device's frame (devices/driver.h) as it stands before a patient in the frame of a CT (LPS): to the user's right
/// is to the patient's left, up is to the head, towards the user is to the front.
inline const Quat kFacingPatient{0.70710678118654752, 0.70710678118654752, 0, 0};

struct WorkspaceParams {
  double motion_scale = 1;     // mm of the tool for each of the handle, 0.02 to 20
  Quat R_WD = kFacingPatient;  // the device's frame in the world
  Vec3 p_TC_mm{0};             // the point of the tool that the handle holds: CouplingParams::p_TC_mm
  bool senses_orientation = false;
};

/// The handle's point C moves the tool's: p_WC = a_W + motion_scale R_WD (p_DC - a_D), a the anchor, the pair of places
/// that were one when it was last dropped. The tool turns as the handle does since then, where that is sensed.
/// Tick-safe but for the constructor.
class Workspace {
 public:
  /// Throws Error naming a parameter out of range. The anchor: the handle's pose 0 at the world's.
  explicit Workspace(const WorkspaceParams& params);

  /// From here on this pose of the handle is that of the tool frame. `R_WD`: and the device's frame lies so.
  void Anchor(const Pose& X_DH, const Pose& X_WT);
  void Anchor(const Pose& X_DH, const Pose& X_WT, const Quat& R_WD);
  /// Of the tool frame, as the hand asks for it.
  Pose CalcToolPose(const Pose& X_DH) const;
  /// The handle's pose for which CalcToolPose() gives this one (where orientation is not sensed: its place).
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

/// The device as it is felt through a workspace: what it holds for a mm of the handle, for a mm of the tool instead.
/// Its forces stay.
DeviceProfile ScaleProfile(DeviceProfile profile, double motion_scale);

/// The device's frame for a left-handed user: the place mirrored about the plane between right and left, up and towards
/// the user kept, as far as a rotation can: its turns about up and about towards the user change sign.
Quat MirrorForLeftHand(const Quat& R_WD, const Quat& R_WD_straight = kFacingPatient);

/// Buttons with the one to the right and the one to the left exchanged.
std::uint32_t ExchangeButtons(std::uint32_t buttons, int right_bit, int left_bit);

}  // namespace kerf
