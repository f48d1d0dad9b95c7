#include "app/window/seen_pose.h"

#include <algorithm>
#include <limits>

#include "session/run/clear_pose.h"

namespace kerf {
namespace {

constexpr double kStep_mm = 1;

/// Way from a point to the eye.
struct WayToEye {
  Vec3 direction_W{0};      // unit length
  double length_mm = 0;     // to the eye, of a parallel view without end
  double past_bone_mm = 0;  // beyond this there is no bone
};
WayToEye FindWayToEye(const ViewCamera& camera, const Box3& bounds_W, const Vec3& p_W) {
  const double past_bone_mm = glm::distance(p_W, bounds_W.centre()) + 0.5 * glm::length(bounds_W.size());
  if (camera.parallel()) return {-camera.forward_W(), std::numeric_limits<double>::infinity(), past_bone_mm};
  const Vec3 to_eye_W = camera.eye_W() - p_W;
  return {glm::normalize(to_eye_W), glm::length(to_eye_W), past_bone_mm};
}

bool IsSeen(const ViewCamera& camera, const ScreenBox& area, const PhiSampler& bone, const Box3& bounds_W,
            double reach_mm, const Vec3& p_W) {
  const std::optional<ScreenPoint> at = camera.Project(p_W);
  if (!at) return false;
  // At least a good part of the tool is in the area.
  const double beyond_px = 0.5 * reach_mm / camera.WorldPerPixel(p_W);
  const auto lies_within = [&](double x, double from, double size) {
    return x >= from - beyond_px && x <= from + size + beyond_px;
  };
  if (!lies_within(at->x, area.left, area.width) || !lies_within(at->y, area.top, area.height)) return false;
  const WayToEye way = FindWayToEye(camera, bounds_W, p_W);
  for (double along_mm = 0; along_mm < std::min(way.length_mm, way.past_bone_mm); along_mm += kStep_mm) {
    if (bone.Calc(p_W + along_mm * way.direction_W) < 0) return false;
  }
  return true;
}

}  // namespace

Pose FindSeenPose(const ViewCamera& camera, const ScreenBox& area, const PhiSampler& bone, const Box3& bounds_W,
                  const Tool& tool, const Pose& X_home) {
  const double reach_mm = CalcReach(tool);
  if (area.empty() || IsSeen(camera, area, bone, bounds_W, reach_mm, X_home.p_AB)) return X_home;
  const Vec3 middle_W =
      camera.Unproject({area.left + 0.5 * area.width, area.top + 0.5 * area.height}, camera.target_W());
  const WayToEye way = FindWayToEye(camera, bounds_W, middle_W);
  // From the eye's side, so that no other part of the bone is in front of it.
  const double nearest_mm = std::max(0.0, std::min(way.length_mm - 3 * reach_mm, way.past_bone_mm + reach_mm));
  Pose X{X_home.R_AB, middle_W};
  for (double along_mm = nearest_mm; along_mm >= 0; along_mm -= kStep_mm) {
    const Pose X_next{X.R_AB, middle_W + along_mm * way.direction_W};
    if (along_mm < nearest_mm && !IsClear(bone, tool, X_next, 0)) break;
    X = X_next;
  }
  return X;
}

}  // namespace kerf
