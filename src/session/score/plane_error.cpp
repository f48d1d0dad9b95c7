#include "session/score/plane_error.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <span>

#include "session/score/fit_plane.h"

namespace kerf {
namespace {

/// Returns the plane across which the removed cells lie least far from it, among those with the tool's lean: a groove
/// as wide as deep does not show how the tool leaned. None if the cells do not determine it.
std::optional<CutPlane> FitGroove(const WantedCut& cut, std::span<const RemovedCell> cells, double lean_deg) {
  // Change of -w with t. A groove does not show the yaw of a tool that leaned more than 60 degrees.
  const auto calc_slope = [lean_deg](double steepest_deg) {
    return std::tan(std::clamp(lean_deg, -steepest_deg, steepest_deg) / kDegreesPerRad);
  };
  const double shear = calc_slope(60);
  const double slope = calc_slope(89);
  double sum = 0;
  Vec3 mean(0);
  for (const RemovedCell& cell : cells) {
    sum += cell.mm3;
    mean += cell.mm3 * cut.ToCut(cell.p_W);
  }
  if (!(sum > 0)) return {};
  mean /= sum;
  double along = 0;
  double across = 0;
  for (const RemovedCell& cell : cells) {
    const Vec3 d = cut.ToCut(cell.p_W) - mean;
    along += cell.mm3 * d.x * d.x;
    across += cell.mm3 * d.x * (d.z + shear * d.y);
  }
  if (!(along > 0)) return {};
  return CutPlane{cut.ToWorld(mean), glm::normalize(cut.across_W - across / along * cut.along_W + slope * cut.into_W)};
}

}  // namespace

PlaneError CalcPlaneError(const CutPlane& fitted, const WantedCut& cut, const Vec3& p_W) {
  Vec3 n = fitted.normal_W;
  if (glm::dot(n, cut.across_W) < 0) n = -n;
  const double along = glm::dot(n, cut.along_W);
  const double into = glm::dot(n, cut.into_W);
  const double across = glm::dot(n, cut.across_W);
  PlaneError error;
  // Distance from the projection of p_W onto the wanted plane, along its normal, to the fitted plane.
  const Vec3 wanted_W = p_W - glm::dot(p_W - cut.start_W, cut.across_W) * cut.across_W;
  error.offset_mm = across > 1e-6 ? glm::dot(fitted.p_W - wanted_W, n) / across : 0;
  error.roll_deg = std::atan2(into, across) * kDegreesPerRad;
  error.yaw_deg = std::atan2(along, across) * kDegreesPerRad;
  error.angle_deg = std::atan2(std::hypot(along, into), across) * kDegreesPerRad;
  return error;
}

std::optional<PlaneError> FindPlaneError(const Bone& before, const Bone& after, const WantedCut& cut,
                                         const std::vector<RemovedCell>& cells, const Vec3& middle_W,
                                         const std::optional<double>& lean_deg) {
  std::optional<CutPlane> fitted;
  if (cut.solid) {
    fitted = FitGroove(cut, cells, lean_deg.value_or(0));
  } else if (const std::optional<MidPlane> plane = FitMidPlane(before, after, cells)) {
    fitted = plane->plane;
  }
  if (!fitted) return {};
  PlaneError error = CalcPlaneError(*fitted, cut, middle_W);
  error.has_roll = !cut.solid || lean_deg;
  return error;
}

void SetPlaneErrors(const std::vector<std::optional<PlaneError>>& errors, ScoreSheet& sheet) {
  PlaneError offset, angle;
  for (const std::optional<PlaneError>& error : errors) {
    if (!error) return;
    if (std::abs(error->offset_mm) >= std::abs(offset.offset_mm)) offset = *error;
    if (error->angle_deg >= angle.angle_deg) angle = *error;
  }
  SetValue(sheet, "plane_offset_mm", offset.offset_mm);
  if (angle.has_roll) SetValue(sheet, "plane_roll_deg", angle.roll_deg);
  SetValue(sheet, "plane_yaw_deg", angle.yaw_deg);
  SetValue(sheet, "plane_angle_deg", angle.angle_deg);
}

}  // namespace kerf
