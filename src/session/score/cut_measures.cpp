#include "session/score/cut_measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>

#include "session/marks/injury_finder.h"
#include "session/marks/region_parts.h"
#include "session/marks/structure_body.h"
#include "session/score/cut_area.h"
#include "session/score/faults.h"

namespace kerf {
namespace {

/// Minimum fraction of a cell's volume that must be removed for the place to count as cut.
constexpr double kCutFraction = 0.02;
/// Depth from which a place of the line counts as begun.
constexpr double kLeastDepth_mm = 0.05;
/// Depth that may lack for a place of the line to count as deep enough; the steps of an exercise permit the same.
constexpr double kDeepEnough_mm = 0.3;
/// Fraction of the line by which a stretch may miss the start of the line and yet begin there.
constexpr double kAtStart = 0.05;

double CalcMean(const std::vector<double>& x) {
  double sum = 0;
  for (const double v : x) sum += v;
  return sum / static_cast<double>(x.size());
}

/// Sets how much of the line was cut at all, and how deep.
void MeasureBegun(const std::vector<double>& depths, ScoreSheet& sheet) {
  if (depths.empty()) return;
  double sum_mm = 0;
  std::size_t begun = 0;
  for (const double depth_mm : depths) {
    if (depth_mm < kLeastDepth_mm) continue;
    sum_mm += depth_mm;
    ++begun;
  }
  sheet.begun_share = static_cast<double>(begun) / static_cast<double>(depths.size());
  if (begun > 0) sheet.depth_mm = sum_mm / static_cast<double>(begun);
}

/// Returns whether the cut beyond the end of a deep stretch is more than what a tool leaves that stopped there.
bool GoesOn(const WantedCut& cut, const std::vector<double>& depths, std::size_t end) {
  constexpr double kMore_mm = 0.3, kPart = 0.1;
  const double step_mm = cut.length_mm / static_cast<double>(depths.size());
  // The tool reaches the least sufficient depth this far ahead of its deepest point.
  const double ahead_mm = cut.CalcReachAlong(kDeepEnough_mm);
  std::size_t more = 0;
  for (std::size_t i = end; i < depths.size(); ++i) {
    const double x_mm = std::min(cut.radius_mm, ahead_mm + static_cast<double>(i - end) * step_mm);
    more += depths[i] > std::max(cut.CalcFloor(x_mm), 0.0) + kMore_mm ? 1 : 0;
  }
  return static_cast<double>(more) > kPart * static_cast<double>(depths.size());
}

/// Sets the stretch of the line that is deep enough.
void MeasureDeep(const WantedCut& cut, const std::vector<double>& depths, ScoreSheet& sheet) {
  const auto deep = [&](double depth_mm) { return depth_mm >= cut.depth_mm - kDeepEnough_mm; };
  const auto first = std::find_if(depths.begin(), depths.end(), deep);
  if (first == depths.end()) return;
  const auto last = std::find_if(depths.rbegin(), depths.rend(), deep).base();
  const auto places = static_cast<double>(depths.size());
  DeepStretch stretch{.share = static_cast<double>(last - first) / places,
                      .from_start = static_cast<double>(first - depths.begin()) < kAtStart * places};
  for (auto depth = first; depth != last; ++depth) {
    stretch.shallow_mm += std::max(cut.depth_mm - *depth, 0.0) / static_cast<double>(last - first);
  }
  stretch.goes_on = GoesOn(cut, depths, static_cast<std::size_t>(last - depths.begin()));
  sheet.deep = stretch;
}

void MeasureDepthErrors(const WantedCut& cut, std::span<const CutColumn> columns, const std::vector<double>& depths,
                        ScoreSheet& sheet) {
  std::vector<double> errors;
  double too_deep_mm = 0;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const double error_mm = depths[i] - cut.depth_mm;
    errors.push_back(std::abs(error_mm));
    too_deep_mm = std::max(too_deep_mm, error_mm);
  }
  if (errors.empty()) return;
  SetValue(sheet, "depth_error_mean_mm", CalcMean(errors));
  std::sort(errors.begin(), errors.end());
  const auto p95 = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(errors.size()))) - 1;
  SetValue(sheet, "depth_error_p95_mm", errors[p95]);
  SetValue(sheet, "depth_error_worst_mm", errors.back());
  SetValue(sheet, "too_deep_mm", too_deep_mm);
}

/// Returns the plane across which the removed cells lie least far from it, among those that contain the direction into
/// the bone: a groove as wide as deep does not show how the tool leaned. None if the cells do not determine it.
std::optional<CutPlane> FitGroove(const WantedCut& cut, std::span<const RemovedCell> cells) {
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
    across += cell.mm3 * d.x * d.z;
  }
  if (!(along > 0)) return {};
  return CutPlane{cut.ToWorld(mean), glm::normalize(cut.across_W - across / along * cut.along_W)};
}

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

/// Fraction of a hole's section times its diameter that is its volume.
constexpr double kHoleFraction = 0.25 * std::numbers::pi;

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

/// Sets the largest offset and the largest angle; none if the plane of a cut is unknown.
void SetPlaneErrors(const std::vector<std::optional<PlaneError>>& errors, ScoreSheet& sheet) {
  PlaneError offset, angle;
  for (const std::optional<PlaneError>& error : errors) {
    if (!error) return;
    if (std::abs(error->offset_mm) >= std::abs(offset.offset_mm)) offset = *error;
    if (error->angle_deg >= angle.angle_deg) angle = *error;
  }
  SetValue(sheet, "plane_offset_mm", offset.offset_mm);
  SetValue(sheet, "plane_roll_deg", angle.roll_deg);
  SetValue(sheet, "plane_yaw_deg", angle.yaw_deg);
  SetValue(sheet, "plane_angle_deg", angle.angle_deg);
}

/// Returns the deviation of the plane that fits what was removed for one cut; none if it has no plane.
std::optional<PlaneError> FindPlaneError(const Bone& before, const Bone& after, const WantedCut& cut,
                                         const std::vector<RemovedCell>& cells, const Vec3& middle_W) {
  std::optional<CutPlane> fitted;
  if (cut.solid) {
    fitted = FitGroove(cut, cells);
  } else if (const std::optional<MidPlane> plane = FitMidPlane(before, after, cells)) {
    fitted = plane->plane;
  }
  if (!fitted) return {};
  return CalcPlaneError(*fitted, cut, middle_W);
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

std::vector<double> MeasureDepths(const Bone& before, const Bone& after, const WantedCut& cut,
                                  std::span<const CutColumn> columns, std::span<const RemovedCell> cells) {
  if (columns.empty()) return {};
  const double h = before.voxel_mm();
  const PhiSampler phi_before(before);
  const PhiSampler phi_after(after);
  // This is negative where bone was removed.
  const auto lost = [&](const Vec3& stw) {
    const Vec3 p_W = cut.ToWorld(stw);
    return std::max(phi_before.Calc(p_W), -phi_after.Calc(p_W));
  };
  struct Deepest {
    double t_mm = -1e300;
    Vec3 stw{0};
  };
  std::vector<Deepest> deepest(columns.size());
  const double step_mm = CalcColumnStep(h, cut);
  for (const RemovedCell& cell : cells) {
    if (cell.mm3 < kCutFraction * h * h * h) continue;
    const Vec3 stw = cut.ToCut(cell.p_W);
    const auto at = std::lower_bound(columns.begin(), columns.end(), stw.x - 0.5 * step_mm,
                                     [](const CutColumn& c, double s) { return c.s_mm < s; });
    if (at == columns.end() || std::abs(at->s_mm - stw.x) > step_mm) continue;
    Deepest& d = deepest[static_cast<std::size_t>(at - columns.begin())];
    if (stw.y > d.t_mm) d = {stw.y, stw};
  }
  std::vector<double> depths(columns.size(), 0);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const Deepest& d = deepest[i];
    if (d.t_mm < -1e200) continue;
    // Bottom of the cut near that cell: where lines into the bone leave the removed region.
    double bottom_mm = -1e300;
    for (int across = -4; across <= 4; ++across) {
      const double w = d.stw.z + 0.5 * across * h;
      double t0 = d.t_mm - 3 * h;
      double lost0 = lost({columns[i].s_mm, t0, w});
      for (double t = t0 + 0.25 * h; t <= d.t_mm + 2 * h; t += 0.25 * h) {
        const double lost1 = lost({columns[i].s_mm, t, w});
        if (lost0 < 0 && lost1 >= 0) bottom_mm = std::max(bottom_mm, t0 + (t - t0) * lost0 / (lost0 - lost1));
        t0 = t;
        lost0 = lost1;
      }
    }
    if (bottom_mm < -1e200) bottom_mm = d.t_mm;
    depths[i] = std::max(bottom_mm - columns[i].near_mm, 0.0);
  }
  return depths;
}

void MeasureCut(const Bone& before, const Bone& after, const std::vector<WantedCut>& cuts, ScoreSheet& sheet) {
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
    planned_mm3 += area.bone_mm2 * cuts[i].thickness_mm * (holes ? kHoleFraction : 1);
    bone_mm2 += area.bone_mm2;
    cut_mm2 += area.cut_mm2;
    errors.push_back(holes ? std::nullopt : FindPlaneError(before, after, cuts[i], parts[i], area.middle_W));
  }
  const double fraction = cut_mm2 / bone_mm2;
  SetValue(sheet, "cut_share", fraction);
  SetValue(sheet, "planned_mm3", planned_mm3);
  SetValue(sheet, "under_mm3", (1 - fraction) * planned_mm3);
  SetValue(sheet, "margin_mm3", removed_mm3 - outside_mm3 - fraction * planned_mm3);
  SetValue(sheet, "dice", 2 * fraction * planned_mm3 / (planned_mm3 + removed_mm3));
  if (cut_mm2 > 0 && !holes) SetValue(sheet, "kerf_width_mm", (removed_mm3 - outside_mm3) / cut_mm2);
  for (MeasureRow& row : sheet.rows) {
    // Half of the points are lost at a quarter of the volume of the wanted cut.
    if (std::string_view(row.info->key) == "outside_mm3") row.half = std::max(0.25 * planned_mm3, 1e-3);
  }
  SetPlaneErrors(errors, sheet);
  // Depth errors are measured only if the goal is a depth, that is, if the bone is not to be cut through.
  if (sheet.kind && IsThrough(*sheet.kind)) return;
  const WantedCut& cut = cuts.front();
  const std::vector<CutColumn> columns = FindColumns(PhiSampler(before), cut, 0);
  const std::vector<double> depths = MeasureDepths(before, after, cut, columns, cells);
  for (std::size_t i = 0; i < depths.size(); ++i) {
    const double bone_mm = columns[i].far_mm - columns[i].near_mm;
    if (bone_mm > cut.depth_mm + cut.margin_mm && depths[i] > bone_mm - before.voxel_mm()) sheet.through_mm = bone_mm;
  }
  MeasureBegun(depths, sheet);
  MeasureDeep(cut, depths, sheet);
  MeasureDepthErrors(cut, columns, depths, sheet);
}

}  // namespace kerf
