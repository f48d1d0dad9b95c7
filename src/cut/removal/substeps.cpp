#include <algorithm>
#include <cmath>

#include "cut/removal/cutter.h"
#include "cut/tool/shape.h"

namespace kerf {

double CountSubsteps(const Pose& a, const Pose& b, const Tool& tool, double voxel_mm) {
  const double move = glm::length(b.p_AB - a.p_AB);
  double across = std::max(1.0, std::ceil(move / (0.5 * voxel_mm)));
  const ToolForm form = GetForm(tool);
  if (form == ToolForm::kBall) return across;
  double radius_mm = CalcRadius(tool);
  if (GetDrive(tool) == DriveMotion::kStroke) {  // such a blade is not round
    radius_mm = CalcReach(tool);
    across = std::max(across, std::ceil(CalcTravel(a, b, radius_mm) / (0.5 * voxel_mm)));
  }
  const Vec3 normal_a = a.Vector({0, 0, 1});
  const Vec3 normal_b = b.Vector({0, 0, 1});
  const double tilt = std::acos(std::clamp(glm::dot(normal_a, normal_b), -1.0, 1.0));
  if (form == ToolForm::kRound) {
    const double turn = tilt * CalcReach(tool);
    return std::max(std::ceil((move + turn) / (0.5 * voxel_mm)), std::max(1.0, std::ceil(turn / (0.25 * voxel_mm))));
  }
  const Vec3 motion = b.p_AB - a.p_AB;
  const double along =
      std::max(std::abs(glm::dot(motion, normal_a)), std::abs(glm::dot(motion, normal_b))) + tilt * (radius_mm + move);
  return std::max(across, std::ceil(along / (0.25 * std::min(CalcThickness(tool), voxel_mm))));
}

Pose Interpolate(const Pose& a, const Pose& b, double t) {
  Pose X;
  X.R_AB = glm::normalize(glm::slerp(a.R_AB, b.R_AB, t));
  X.p_AB = a.p_AB + t * (b.p_AB - a.p_AB);
  return X;
}

}  // namespace kerf
