// Whether a tool is clear of a bone, and ways out of it.
#pragma once

#include <vector>

#include "bone/grid/removed.h"
#include "kerf/tool.h"

namespace kerf {

/// Returns true if every point of the tool's surface and of a disc's middle plane is at least `margin_mm` outside the
/// bone; a negative margin permits a penetration. `phi` saturates at the width of the bone's band, so a margin of more
/// than two voxels is not reached anywhere. Tests points about a voxel apart.
bool IsClear(const PhiSampler& phi, const Tool& tool, const Pose& X_WT, double margin_mm);

/// Returns the nearest pose with the same orientation that is clear of the bone by `margin_mm`, found in steps of half
/// a millimetre: in the plane of a disc, up to `max_mm` away, otherwise in any direction. Returns `X_WT` moved by
/// `max_mm` away from `p_inside_W`, a point in the middle of the bone, if there is none.
Pose FindNearestClearPose(const PhiSampler& phi, const Tool& tool, const Pose& X_WT, const Vec3& p_inside_W,
                          double margin_mm, double max_mm);

/// Returns the corners of a way between two poses that are clear of the bone by `margin_mm`, on which the tool stays
/// clear of it: the end alone or, if bone is in the way, two poses at most `max_mm` away from the bone and the end.
/// Looks every 3 mm. Empty if none was found. `p_inside_W`: a point in the middle of the bone.
std::vector<Pose> FindClearWay(const PhiSampler& phi, const Tool& tool, const Pose& X_from, const Pose& X_to,
                               const Vec3& p_inside_W, double margin_mm, double max_mm);

/// Poses of a tool, in order, with a distance of at least `kStep_mm` or `kStep_rad` between neighbours. Keeps the
/// latest poses only, and only those since the tool was last moved without a path.
class ToolTrail {
 public:
  static constexpr double kStep_mm = 0.2;
  static constexpr double kStep_rad = 0.02;
  static constexpr double kJump_mm = 3;  // between two ticks: faster than any hand
  static constexpr std::size_t kMaxPoses = 4096;

  void Take(const Pose& X_WT);
  const std::vector<Pose>& poses() const { return poses_; }

  /// Returns the way back along the trail from `X_WT` to the last pose that was clear of the bone by `margin_mm`,
  /// without the detours on which the tool came back to where it had been. Empty if no pose of the trail is clear.
  std::vector<Pose> FindWayBack(const PhiSampler& phi, const Tool& tool, const Pose& X_WT, double margin_mm) const;

 private:
  std::vector<Pose> poses_;  // oldest first
};

/// Returns the poses at the ends of ticks of a motion through `corners` at a constant speed. `reach_mm` converts angles
/// to distances.
std::vector<Pose> DivideIntoTicks(const std::vector<Pose>& corners, double speed_mm_per_s, double period_s,
                                  double reach_mm);

}  // namespace kerf
