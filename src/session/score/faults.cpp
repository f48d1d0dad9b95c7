#include "session/score/faults.h"

#include <algorithm>
#include <cmath>

namespace kerf {
namespace {

/// Mean depth error from which a cut that is not too deep counts as too shallow.
constexpr double kShallow_mm = 0.15;
/// Fraction of the removed bone from which on an attempt is one beside the wanted cut.
constexpr double kMostlyBeside = 0.5;
/// A fitted plane is not that of the cut if it has more than this angle to the wanted one, or lies further away than
/// all removed bone by more than this.
constexpr double kMaxFitted_deg = 45;
constexpr double kBeyondCut_mm = 1;
/// Mean depth of an attempt without a score from which on its plane is shown.
constexpr double kLeastPlane_mm = 1;

}  // namespace

double GetOrZero(const ScoreSheet& sheet, std::string_view key) {
  return sheet.Get(key).value_or(0);
}

bool IsThrough(ExerciseKind kind) {
  return kind == ExerciseKind::kBicortical || kind == ExerciseKind::kOsteotomy || kind == ExerciseKind::kDrillHoles;
}

double CalcBeside_mm3(const ScoreSheet& sheet) {
  return std::max(GetOrZero(sheet, "outside_mm3") - sheet.below_mm3 - sheet.beyond_mm3, 0.0);
}

bool IsBeside(const ScoreSheet& sheet) {
  return std::abs(GetOrZero(sheet, "plane_offset_mm")) > sheet.exercise.margin_mm;
}

bool IsMostlyBeside(const ScoreSheet& sheet) {
  return sheet.beside_mm && *sheet.beside_mm > sheet.exercise.margin_mm &&
         CalcBeside_mm3(sheet) >= kMostlyBeside * GetOrZero(sheet, "removed_mm3");
}

bool IsPlaneSensible(const ScoreSheet& sheet) {
  // A scratch has a place, but not a plane whose angle is known.
  if (!sheet.total && sheet.depth_mm && *sheet.depth_mm < kLeastPlane_mm) return false;
  return GetOrZero(sheet, "plane_angle_deg") <= kMaxFitted_deg &&
         (!sheet.farthest_mm || std::abs(GetOrZero(sheet, "plane_offset_mm")) <= *sheet.farthest_mm + kBeyondCut_mm);
}

bool IsOfPlane(std::string_view key) {
  return key.substr(0, 6) == "plane_";
}

bool IsShallow(const ScoreSheet& sheet) {
  return GetOrZero(sheet, "depth_error_mean_mm") > kShallow_mm &&
         GetOrZero(sheet, "depth_error_worst_mm") > GetOrZero(sheet, "too_deep_mm") + kShallow_mm;
}

Fault FaultOf(std::string_view key, bool beside, bool shallow) {
  if (key == "plane_offset_mm" || key == "hole_offset_mm") return Fault::kBeside;
  if (key == "plane_angle_deg" || key == "hole_angle_deg") return Fault::kTilted;
  if (key == "too_deep_mm") return Fault::kTooDeep;
  if (key == "plunge_max_mm") return Fault::kPlunge;
  if (key == "outside_mm3") return beside ? Fault::kBeside : Fault::kOutside;
  if (key == "near_miss_s" || key == "breaches" || key == "breach_mm3") return Fault::kNerve;
  if (key == "jitter_mm") return Fault::kTrembling;
  if (key == "path_length_mm") return Fault::kLongPath;
  if (key == "time_total_s") return Fault::kSlow;
  if (key == "feed_error") return Fault::kFeed;
  return beside ? Fault::kBeside : shallow ? Fault::kTooShallow : Fault::kMissing;
}

std::vector<FaultLoss> FindLosses(const ScoreSheet& sheet) {
  std::vector<FaultLoss> losses;
  if (!sheet.total || !sheet.kind) return losses;
  const bool beside = IsBeside(sheet);
  const bool shallow = IsShallow(sheet);
  const auto add = [&](Fault fault, double lost) {
    if (!(lost > 0)) return;
    const auto at = std::find_if(losses.begin(), losses.end(), [&](const FaultLoss& l) { return l.fault == fault; });
    if (at == losses.end()) {
      losses.push_back({fault, lost});
    } else {
      at->lost += lost;
    }
  };
  double weights = 0;
  double mean = 0;
  for (const MeasureRow& row : sheet.rows) weights += row.weight;
  for (const MeasureRow& row : sheet.rows) {
    if (row.weight == 0) continue;
    const double points = row.points.value_or(0);
    mean += row.weight * points / weights;
    double lost = 100 * row.weight * (1 - points) / weights;
    if (std::string_view(row.info->key) == "outside_mm3" && row.value.value_or(0) > 0) {
      const double below = lost * sheet.below_mm3 / *row.value;
      const double beyond = lost * sheet.beyond_mm3 / *row.value;
      // Where the bone is cut through, there is no depth.
      add(IsThrough(*sheet.kind) ? Fault::kBeyondEnd : Fault::kTooDeep, below);
      add(Fault::kBeyondEnd, beyond);
      lost -= below + beyond;
    }
    add(FaultOf(row.info->key, beside, shallow), lost);
  }
  // total = 100 x cut_share x mean, so that this and the losses above add up to 100 - total.
  add(FaultOf("cut_share", beside, shallow), 100 * (1 - GetOrZero(sheet, "cut_share")) * mean);
  std::stable_sort(losses.begin(), losses.end(),
                   [](const FaultLoss& a, const FaultLoss& b) { return a.lost > b.lost; });
  return losses;
}

}  // namespace kerf
