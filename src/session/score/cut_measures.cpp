#include "session/score/cut_measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>

#include "bone/grid/removed.h"
#include "session/marks/injury_finder.h"
#include "session/marks/region_parts.h"
#include "session/marks/structure_body.h"
#include "session/score/cut_area.h"
#include "session/score/cut_picture.h"
#include "session/score/depths.h"
#include "session/score/faults.h"
#include "session/score/plane_error.h"

namespace kerf {
namespace {

bool IsCanalSevered(const Bone& before, const Bone& after) {
  const RegionParts parts(before, Tissue::kCanal, before.CalcBounds().centre().x);
  for (std::size_t i = 0; i < parts.structures().size(); ++i) {
    if (StructureBody(before, parts, static_cast<int>(i)).IsSevered(after)) return true;
  }
  return false;
}

/// Finds the structures that were injured further than the margin from the wanted cut and, for a planned cut, within
/// it.
void FindInjuries(const Bone& before, const Bone& after, const std::vector<WantedCut>& cuts, ScoreSheet& sheet) {
  InjuryFinder finder(std::shared_ptr<const Bone>(std::shared_ptr<const Bone>(), &before));
  finder.Change(after, FindChangedLeaves(before, after));
  finder.Find(after);
  std::vector<OutsideInjury>& injured = sheet.injured;
  for (StructureResult& structure :
       finder.FindAt([&](const Vec3& p_W) { return !FindNearestCut(cuts, p_W).IsNear(p_W); })) {
    const WantedCut& cut = FindNearestCut(cuts, structure.p_W);
    const double away_mm = std::max(cut.CalcDistance(structure.p_W), cut.margin_mm);
    injured.push_back({.structure = std::move(structure), .away_mm = away_mm});
  }
  std::stable_sort(injured.begin(), injured.end(), [](const OutsideInjury& a, const OutsideInjury& b) {
    return a.structure.removed_mm3 > b.structure.removed_mm3;
  });
  if (sheet.kind == ExerciseKind::kOsteotomy) {
    sheet.crossed = finder.FindAt([&](const Vec3& p_W) { return FindNearestCut(cuts, p_W).IsNear(p_W); });
  }
}

/// Returns the removed cells of each cut: those that are nearer to it than to the others.
std::vector<std::vector<RemovedCell>> DivideAmong(const std::vector<WantedCut>& cuts,
                                                  const std::vector<RemovedCell>& cells) {
  if (cuts.size() == 1) return {cells};
  std::vector<std::vector<RemovedCell>> parts(cuts.size());
  for (const RemovedCell& cell : cells) {
    parts[static_cast<std::size_t>(&FindNearestCut(cuts, cell.p_W) - cuts.data())].push_back(cell);
  }
  return parts;
}

/// Sets what was removed outside the wanted cuts and their margin, and returns it.
double MeasureOutside(const std::vector<WantedCut>& cuts, const std::vector<RemovedCell>& cells, double removed_mm3,
                      ScoreSheet& sheet) {
  double outside_mm3 = 0;
  double beside_sum = 0;
  double farthest_mm = 0;
  for (const RemovedCell& cell : cells) {
    const WantedCut& cut = FindNearestCut(cuts, cell.p_W);
    const Vec3 stw = cut.ToCut(cell.p_W);
    beside_sum += cell.mm3 * std::abs(stw.z);
    farthest_mm = std::max(farthest_mm, std::abs(stw.z));
    if (cut.IsNear(cell.p_W)) continue;
    outside_mm3 += cell.mm3;
    if (std::abs(stw.z) > cut.margin_mm + 0.5 * cut.thickness_mm) continue;
    (stw.y > cut.depth_mm ? sheet.below_mm3 : sheet.beyond_mm3) += cell.mm3;
  }
  SetValue(sheet, "outside_mm3", outside_mm3);
  if (removed_mm3 > 0) {
    sheet.beside_mm = beside_sum / removed_mm3;
    sheet.farthest_mm = farthest_mm;
  }
  return outside_mm3;
}

}  // namespace

void MeasureCut(const Bone& before, const Bone& after, const std::vector<WantedCut>& cuts,
                std::span<const std::optional<double>> leans_deg, ScoreSheet& sheet) {
  const std::vector<RemovedCell> cells = FindRemoved(before, after);
  const std::array<bool, 256> canal = FindRegionsOf(before, Tissue::kCanal);
  double removed_mm3 = 0;
  double breach_mm3 = 0;
  for (const RemovedCell& cell : cells) {
    removed_mm3 += cell.mm3;
    if (cell.region > 0 && cell.region < 256 && canal[static_cast<std::size_t>(cell.region)]) breach_mm3 += cell.mm3;
  }
  SetValue(sheet, "removed_mm3", removed_mm3);
  if (std::find(canal.begin(), canal.end(), true) != canal.end()) SetValue(sheet, "breach_mm3", breach_mm3);
  sheet.canal_severed = breach_mm3 > 0 && IsCanalSevered(before, after);
  if (cuts.empty()) return;

  if (removed_mm3 > 0 && cuts.size() == 1) sheet.picture = MakeCutPicture(before, after, cuts.front(), cells);
  const double outside_mm3 = MeasureOutside(cuts, cells, removed_mm3, sheet);
  if (outside_mm3 > 0 || (sheet.kind == ExerciseKind::kOsteotomy && removed_mm3 > 0)) {
    FindInjuries(before, after, cuts, sheet);
  }
  const bool holes = sheet.kind == ExerciseKind::kDrillHoles;
  const auto parts = DivideAmong(cuts, cells);
  double planned_mm3 = 0;
  double bone_mm2 = 0;
  double cut_mm2 = 0;
  std::vector<std::optional<PlaneError>> errors;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const CutArea area = CalcCutArea(before, after, cuts[i]);
    if (!(area.bone_mm2 > 0)) {
      sheet.warnings.push_back(cuts.size() == 1 ? "the wanted cut does not intersect the bone"
                                                : fmt::format("the wanted cut {} does not intersect the bone", i + 1));
      return;
    }
    planned_mm3 += area.bone_mm3;
    bone_mm2 += area.bone_mm2;
    cut_mm2 += area.cut_mm2;
    const std::optional<double> lean_deg = leans_deg.empty() ? std::nullopt : leans_deg[i];
    errors.push_back(holes ? std::nullopt : FindPlaneError(before, after, cuts[i], parts[i], area.middle_W, lean_deg));
  }
  const double fraction = cut_mm2 / bone_mm2;
  SetValue(sheet, "cut_share", fraction);
  SetValue(sheet, "planned_mm3", planned_mm3);
  // Where cuts overlap, less was removed than the sum of their areas says.
  const double made_mm3 = std::min(fraction * planned_mm3, removed_mm3 - outside_mm3);
  SetValue(sheet, "under_mm3", planned_mm3 - made_mm3);
  SetValue(sheet, "margin_mm3", removed_mm3 - outside_mm3 - made_mm3);
  SetValue(sheet, "dice", 2 * made_mm3 / (planned_mm3 + removed_mm3));
  if (cut_mm2 > 0 && !holes) SetValue(sheet, "kerf_width_mm", (removed_mm3 - outside_mm3) / cut_mm2);
  for (MeasureRow& row : sheet.rows) {
    // Half of the points are lost at a quarter of the volume of the wanted cut.
    if (std::string_view(row.info->key) == "outside_mm3") row.half = std::max(0.25 * planned_mm3, 1e-3);
  }
  SetPlaneErrors(errors, sheet);
  // Depth errors are measured only if the goal is a depth, that is, if the bone is not to be cut through.
  if (sheet.kind && IsThrough(*sheet.kind)) return;
  MeasureLineDepths(before, after, cuts.front(), cells, sheet);
}

}  // namespace kerf
