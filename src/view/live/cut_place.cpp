#include "view/live/cut_place.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "cut/tool/looks.h"
#include "cut/tool/shape.h"

namespace kerf {
namespace {

/// Returns the mean of the points of an edge that lie in the bone, tool frame.
std::optional<Vec3> FindEdgeInBone(const Tool& tool, const Pose& X_WT, const Bone& uncut) {
  constexpr int kPerPitch = 2;
  Vec3 sum(0);
  int count = 0;
  for (const EdgePoint& point : MakeToolShape(tool, {kPerPitch, CalcReach(tool), 0, 0}).edge) {
    if (uncut.SignedDistance(X_WT.Point(point.p_T)) >= 0) continue;
    sum += point.p_T;
    ++count;
  }
  return count > 0 ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
}

}  // namespace

std::optional<Vec3> EstimateContact(const Tool& tool, const Pose& X_WT, const Vec3& f_T_W_N, const Bone* uncut) {
  constexpr double kLeast_N = 0.02;
  Vec3 f_T = X_WT.InverseVector(f_T_W_N);
  if (IsBlade(tool)) f_T.z = 0;
  if (!(glm::length(f_T) > kLeast_N)) return std::nullopt;
  if (uncut != nullptr && CalcStroke(tool) > 0) {
    if (const std::optional<Vec3> p_T = FindEdgeInBone(tool, X_WT, *uncut)) return X_WT.Point(*p_T);
  }
  return X_WT.Point(FindForemost(tool, -f_T));
}

void CutPlace::Update(const Tool& tool, const Pose& X_WT, const Vec3& f_T_W_N, double dt_s, const Bone* uncut) {
  constexpr double kSmoothing_s = 0.15;
  if (const std::optional<Vec3> now = EstimateContact(tool, X_WT, f_T_W_N, uncut)) {
    const Vec3 p_T = X_WT.InversePoint(*now);
    const double kept = p_T_ ? std::exp(-std::max(0.0, dt_s) / kSmoothing_s) : 0;
    p_T_ = kept * p_T_.value_or(p_T) + (1 - kept) * p_T;
    // The mean is brought back to the rim of a disc, or to the surface of a ball. Other tools are slender.
    const bool is_disc_or_ball = GetForm(tool) != ToolForm::kRound && GetDrive(tool) == DriveMotion::kRotation;
    if (is_disc_or_ball) p_T_ = CalcRadius(tool) * CalcDirection(*p_T_).value_or(glm::normalize(p_T));
    since_s_ = 0;
  } else {
    since_s_ += std::max(0.0, dt_s);
    if (since_s_ > kHold_s) p_T_.reset();
  }
  p_W_ = p_T_ ? std::optional(X_WT.Point(*p_T_)) : std::nullopt;
}

}  // namespace kerf
