#include "session/score/holes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kerf {
namespace {

/// Depth from which a hole counts as begun.
constexpr double kBegunHole_mm = 0.1;
/// Fraction of the wanted depth, or of the bone's thickness, from which a hole counts as drilled.
constexpr double kDrilled = 0.5;

/// Returns where the axis of a hole meets the bone; none: nowhere.
std::optional<CutColumn> FindBone(const PhiSampler& before, const WantedCut& hole) {
  const std::vector<CutColumn> columns = FindColumns(before, hole, 0);
  return columns.empty() ? std::nullopt : std::optional(columns.front());
}

}  // namespace

std::optional<HoleResult> MeasureHole(const PhiSampler& before, const WantedCut& hole, const Pose& X_WT) {
  WantedCut made = hole;
  made.into_W = X_WT.R_AB * Vec3(0, 0, -1);
  const double cosine = glm::dot(made.into_W, hole.into_W);
  if (!(cosine > 0)) return {};
  // The place where the drill's axis passes the planned place.
  made.start_W = X_WT.p_AB - glm::dot(X_WT.p_AB - hole.start_W, hole.into_W) / cosine * made.into_W;
  const std::optional<CutColumn> bone = FindBone(before, made);
  if (!bone) return {};
  const double tip_mm = made.ToCut(X_WT.p_AB).y;
  const Vec3 entry = hole.ToCut(made.ToWorld({0, bone->near_mm, 0}));
  HoleResult result{.depth_mm = tip_mm - bone->near_mm,
                    .beyond_mm = tip_mm - bone->far_mm,
                    .offset_mm = std::hypot(entry.x, entry.z),
                    .angle_deg = std::acos(std::min(cosine, 1.0)) * kDegreesPerRad};
  result.through = hole.solid && result.beyond_mm >= hole.solid->corner_z_mm;
  if (result.depth_mm < kBegunHole_mm) return {};
  return result;
}

void MeasureHoles(const Bone& before, const std::vector<WantedCut>& holes,
                  const std::vector<std::optional<Pose>>& deepest, ScoreSheet& sheet) {
  const PhiSampler phi(before);
  std::size_t begun = 0, drilled = 0, through = 0;
  double offset_mm = 0, angle_deg = 0, plunge_mm = 0, wanted_beyond_mm = 0;
  for (std::size_t i = 0; i < holes.size(); ++i) {
    const std::optional<CutColumn> bone = FindBone(phi, holes[i]);
    sheet.holes.emplace_back();
    if (!bone) continue;  // MeasureCut() has warned
    const double bone_mm = bone->far_mm - bone->near_mm;
    wanted_beyond_mm = std::max(wanted_beyond_mm, holes[i].depth_mm - bone_mm);
    if (deepest[i]) sheet.holes.back() = MeasureHole(phi, holes[i], *deepest[i]);
    if (!sheet.holes.back()) continue;
    const HoleResult& hole = *sheet.holes.back();
    ++begun;
    drilled += hole.depth_mm >= kDrilled * std::min(holes[i].depth_mm, bone_mm) ? 1 : 0;
    through += hole.through ? 1 : 0;
    offset_mm = std::max(offset_mm, hole.offset_mm);
    angle_deg = std::max(angle_deg, hole.angle_deg);
    plunge_mm = std::max(plunge_mm, hole.beyond_mm);
  }
  SetValue(sheet, "line_share", static_cast<double>(drilled) / static_cast<double>(holes.size()));
  SetValue(sheet, "holes_through", static_cast<double>(through));
  if (begun == 0) return;
  SetValue(sheet, "plunge_max_mm", plunge_mm);
  SetValue(sheet, "hole_offset_mm", offset_mm);
  SetValue(sheet, "hole_angle_deg", angle_deg);
  for (MeasureRow& row : sheet.rows) {
    if (std::string_view(row.info->key) != "plunge_max_mm") continue;
    // A drill's tip has to leave the far side before its whole width does.
    row.goal = wanted_beyond_mm;
    row.half += wanted_beyond_mm;
  }
}

}  // namespace kerf
