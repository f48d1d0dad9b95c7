#include "session/score/review_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "session/score/faults.h"

namespace kerf {
namespace {

/// Fraction of its points from which a figure that costs points is fair rather than bad.
constexpr double kFairPoints = 0.5;
/// Distance from the nerve canal that is fair.
constexpr double kNerveFair_mm = 1;

struct Label {
  std::string_view key;
  const char* text;
  const char* meaning;  // what the measure says, in words that a student knows
};
constexpr std::array kLabels{
    Label{"cut_share", MarkMessage("Wanted cut made"),
          MarkMessage("How much of the wanted cut was made. The rest of it is still bone.")},
    Label{"line_share", MarkMessage("At half depth or more"),
          MarkMessage(
              "How much of the line was cut to at least half of the wanted depth. A disc reaches that depth some "
              "millimetres ahead of its lowest point, so 100 % may be reached before the blade is at the line's end.")},
    Label{"depth_error_mean_mm", MarkMessage("Depth error, mean"),
          MarkMessage("How far the depth of your cut is from the wanted depth, on average along the line.")},
    Label{"depth_error_p95_mm", MarkMessage("Depth error, 95 %"),
          MarkMessage("Along 95 % of the line, the depth of your cut is no further from the wanted depth than this.")},
    Label{"depth_error_worst_mm", MarkMessage("Depth error, largest"),
          MarkMessage("How far the depth of your cut is from the wanted depth where it is worst. A round blade leaves "
                      "bone at the ends of the line, so this is seldom 0.")},
    Label{"too_deep_mm", MarkMessage("Too deep by"),
          MarkMessage("How much deeper than wanted your cut is at its deepest place.")},
    Label{"plunge_max_mm", MarkMessage("Plunge, largest"),
          MarkMessage("How far the blade came out of the far side of the bone.")},
    Label{
        "plunge_mean_mm", MarkMessage("Plunge, mean"),
        MarkMessage("How far the blade came out of the far side of the bone, on average of all the times it did so.")},
    Label{"plunges", MarkMessage("Plunges"), MarkMessage("How often the blade came out of the far side of the bone.")},
    Label{"plane_offset_mm", MarkMessage("Beside the plan"),
          MarkMessage("How far your cut lies to the side of the wanted plane, in the middle of the cut. The sign only "
                      "tells on which side.")},
    Label{
        "plane_roll_deg", MarkMessage("Lean to the side"),
        MarkMessage("How much your cut leans to the side, as seen along the line. The sign only tells to which side.")},
    Label{"plane_yaw_deg", MarkMessage("Turn from the line"),
          MarkMessage("How much your cut is turned away from the line, as seen from above. The sign only tells in "
                      "which direction.")},
    Label{"plane_angle_deg", MarkMessage("Angle to the plan"),
          MarkMessage("The angle between your cut and the wanted plane.")},
    Label{"hole_offset_mm", MarkMessage("Hole beside its place"),
          MarkMessage("How far the axis of the worst hole lies from the wanted one, at the surface.")},
    Label{"hole_angle_deg", MarkMessage("Tilt of a hole"),
          MarkMessage("The angle between the axis of the worst hole and the wanted one.")},
    Label{"holes_through", MarkMessage("Holes through the bone"),
          MarkMessage("How many holes go through the far side over the whole width of the drill.")},
    Label{"outside_mm3", MarkMessage("Removed outside"),
          MarkMessage("Bone that was removed where none should be: beside, below or beyond the ends of the wanted cut, "
                      "further than the permitted margin.")},
    Label{"removed_mm3", MarkMessage("Removed in total"), MarkMessage("All the bone that you removed.")},
    Label{"planned_mm3", MarkMessage("Planned volume"), MarkMessage("The bone that a perfect cut removes.")},
    Label{"under_mm3", MarkMessage("Left uncut"), MarkMessage("Bone in the wanted cut that was not removed.")},
    Label{"margin_mm3", MarkMessage("Within the margin"),
          MarkMessage("Bone that was removed beside the wanted cut, but no further from it than the permitted margin. "
                      "What you removed in total is the planned volume without what was left uncut, and this, and what "
                      "was removed outside.")},
    Label{"dice", MarkMessage("Overlap (Dice)"),
          MarkMessage(
              "How well your cut and the wanted cut agree: 1 if they are the same, 0 if they have nothing in common.")},
    Label{"kerf_width_mm", MarkMessage("Width of the cut"),
          MarkMessage("How wide your cut is. A blade that is tilted or moved to the side makes it wider than the blade "
                      "is thick.")},
    Label{"force_mean_N", MarkMessage("Force, mean"),
          MarkMessage("The force on your hand while the blade touched bone, on average.")},
    Label{"force_peak_N", MarkMessage("Force, peak"), MarkMessage("The largest force on your hand.")},
    Label{"force_rms_N", MarkMessage("Force, RMS"),
          MarkMessage(
              "The force on your hand while the blade touched bone, as an average in which large forces count more.")},
    Label{"force_over_s", MarkMessage("Above force limit"),
          MarkMessage("How long the force on your hand was above the limit of the exercise.")},
    Label{"feed_mean_mm_per_s", MarkMessage("Feed, mean"),
          MarkMessage("How fast the saw moved along the line at depth, on average; if it did not do so, how fast it "
                      "moved while it touched bone.")},
    Label{"feed_cv", MarkMessage("Unevenness of feed"),
          MarkMessage("How much the speed of the saw varied while it touched bone: 0 is a constant speed, and at 1 it "
                      "varied by as much as its average. Pauses make it larger.")},
    Label{
        "feed_error", MarkMessage("Feed differs by"),
        MarkMessage("How much the speed of the saw along the line differed from the wanted one, on average. A saw that "
                    "is stopped differs by 100 %.")},
    Label{"sparc", MarkMessage("Smoothness (SPARC)"),
          MarkMessage("How smoothly the saw moved: the closer to 0, the smoother. One even movement has about -1.8; "
                      "each pause and jerk adds to it, so compare only attempts at the same exercise.")},
    Label{"jitter_mm", MarkMessage("Trembling"), MarkMessage("How much the saw trembled while it touched bone.")},
    Label{"time_total_s", MarkMessage("Time"),
          MarkMessage("The time from the first movement of the saw, or from the moment the spindle was switched on, to "
                      "the end of the attempt.")},
    Label{"time_active_s", MarkMessage("Time in contact"), MarkMessage("The time in which the saw touched bone.")},
    Label{"path_length_mm", MarkMessage("Path of the saw"),
          MarkMessage("The length of the way that the saw took in the whole attempt.")},
    Label{"strokes", MarkMessage("Strokes"), MarkMessage("How often the saw came to touch the bone.")},
    Label{"nerve_distance_mm", MarkMessage("Distance to the nerve"),
          MarkMessage("The smallest distance between the turning blade and the nerve canal. A value below 0 says how "
                      "deep the blade was inside the canal.")},
    Label{"near_miss_s", MarkMessage("Time near the nerve"),
          MarkMessage("How long the turning blade was closer than 2 mm to the nerve canal.")},
    Label{"breaches", MarkMessage("Cuts into the nerve"), MarkMessage("How often the blade cut into the nerve canal.")},
    Label{"breach_mm3", MarkMessage("Nerve canal removed"), MarkMessage("How much of the nerve canal was removed.")},
};

const Label* FindLabel(std::string_view key) {
  const auto at = std::find_if(kLabels.begin(), kLabels.end(), [&](const Label& l) { return l.key == key; });
  return at == kLabels.end() ? nullptr : &*at;
}

constexpr std::array kGrooveFigures{"plane_offset_mm", "plane_angle_deg", "too_deep_mm", "cut_share", "time_total_s"};
constexpr std::array kStopFigures{"too_deep_mm", "depth_error_mean_mm", "plane_offset_mm", "plane_angle_deg",
                                  "cut_share"};
constexpr std::array kThroughFigures{"plunge_max_mm", "plane_offset_mm", "plane_angle_deg", "cut_share",
                                     "time_total_s"};
constexpr std::array kCanalFigures{"nerve_distance_mm", "breach_mm3", "too_deep_mm", "plane_offset_mm", "cut_share"};
constexpr std::array kLineFigures{"feed_error", "plane_offset_mm", "plane_angle_deg", "too_deep_mm", "cut_share"};
constexpr std::array kHoleFigures{"plunge_max_mm", "hole_offset_mm", "hole_angle_deg", "cut_share", "outside_mm3"};
constexpr std::array kOsteotomyFigures{"plane_offset_mm", "plane_angle_deg", "cut_share", "outside_mm3",
                                       "time_total_s"};

/// Returns the value of the measure, as it is shown, that cannot be improved; none if there is no such value.
std::optional<double> PerfectOf(const MeasureInfo& info) {
  const std::string_view key = info.key;
  if (key == "cut_share" || key == "line_share") return 100;
  if (key == "dice") return 1;
  if (key == "under_mm3" || key.substr(0, 11) == "depth_error") return 0;
  const bool with_goal = key == "time_total_s" || key == "path_length_mm" || key == "feed_error";
  return info.scored() && !with_goal ? std::optional(0.0) : std::nullopt;
}

/// Returns a quantity that does not read as the perfect value unless it is that.
Quantity KeepFromPerfect(Quantity shown, double perfect) {
  constexpr double kSame = 1e-3;  // difference that is no more than rounding, in the unit that is shown
  constexpr int kMostDigits = 2;
  const double difference = shown.value - perfect;
  if (std::abs(difference) < kSame) return shown;
  const auto reads_perfect = [&] {
    return FormatQuantity(shown) == FormatQuantity({perfect, shown.digits, shown.unit});
  };
  const bool is_percent = std::string_view(shown.unit) == "%";
  while (reads_perfect() && shown.digits < kMostDigits && !is_percent) ++shown.digits;
  if (reads_perfect()) shown.value = perfect + std::copysign(std::pow(10.0, -shown.digits), difference);
  return shown;
}

Quantity ShowRounded(const MeasureInfo& info, double value) {
  const std::string_view key = info.key;
  const std::string_view unit = info.unit;
  if (key == "cut_share" || key == "line_share" || key == "feed_error") return {100 * value, 0, "%"};
  if (key == "plunges" || key == "strokes" || key == "breaches" || key == "holes_through") return {value, 0, ""};
  if (key == "jitter_mm") return {value, 2, "mm"};
  if (key == "path_length_mm") return {value, 0, "mm"};
  if (unit == "mm3") return {value, std::abs(value) < 10 ? 1 : 0, "mm³"};
  if (unit == "degrees") return {value, 1, "°"};
  if (unit == "s") return {value, std::abs(value) < 10 ? 1 : 0, "s"};
  if (unit.empty()) return {value, 2, ""};
  return {value, 1, info.unit};
}

ReviewLevel LevelOf(bool good, bool fair) {
  return good ? ReviewLevel::kGood : fair ? ReviewLevel::kWarn : ReviewLevel::kBad;
}

/// Returns the mark of a scored figure. `costs`: it costs points, as they are shown; `points`: of the figure, 0 to 1.
ReviewLevel ScoredLevel(bool costs, double points) {
  return LevelOf(!costs, points >= kFairPoints);
}

/// Returns the points of a scored measure, also in an attempt that is not graded.
double PointsOf(const MeasureRow& row) {
  if (!row.value) return 0;
  if (std::string_view(row.info->key) == "cut_share") return *row.value;
  return CalcPoints(*row.value, row.half, row.goal);
}

void SetGoal(ReviewFigure& figure, GoalRelation relation, double value) {
  figure.relation = relation;
  figure.goal = ShowMeasure(*figure.info, value);
  if (figure.goal->value == std::round(figure.goal->value)) figure.goal->digits = 0;
}

ReviewFigure MakeFigure(const ScoreSheet& sheet, const MeasureRow& row) {
  ReviewFigure figure;
  figure.info = row.info;
  figure.label = LabelOf(*row.info);
  const std::string_view key = row.info->key;
  const bool has_sign =
      key == "plane_roll_deg" || key == "plane_yaw_deg" || key == "sparc" || key == "nerve_distance_mm";
  if (row.value) figure.value = ShowMeasure(*row.info, has_sign ? *row.value : std::abs(*row.value));
  if (!sheet.kind) return figure;
  if (key == "cut_share") {
    figure.scored = true;
    SetGoal(figure, GoalRelation::kEqual, 1);
  } else if (key == "nerve_distance_mm" && *sheet.kind == ExerciseKind::kBesideCanal) {
    SetGoal(figure, GoalRelation::kAtLeast, kNerveGood_mm);
    if (row.value) figure.level = LevelOf(*row.value >= kNerveGood_mm, *row.value >= kNerveFair_mm);
  } else if (key == "depth_error_mean_mm") {
    const double good_mm = 0.5 * sheet.exercise.margin_mm;
    SetGoal(figure, GoalRelation::kAtMost, good_mm);
    const double error_mm = std::abs(row.value.value_or(0));
    figure.level = LevelOf(error_mm <= good_mm, error_mm <= sheet.exercise.margin_mm);
  } else if (row.weight > 0) {
    figure.scored = true;
    if (row.goal > 0) {
      SetGoal(figure, GoalRelation::kAtMost, row.goal);
    } else {
      SetGoal(figure, GoalRelation::kEqual, 0);
    }
  }
  if (IsOfPlane(key) && !IsPlaneSensible(sheet)) figure.value.reset();
  double weights = 0;
  for (const MeasureRow& r : sheet.rows) weights += r.weight;
  if (figure.scored) {
    // In a graded attempt, RoundLosses() replaces this by the points that are shown.
    const double weight = key == "cut_share" ? weights : row.weight;
    figure.level = ScoredLevel(100 * weight * (1 - PointsOf(row)) >= 0.5 * weights, PointsOf(row));
  }
  if (!sheet.total) return figure;
  double mean = 0;  // of the points
  for (const MeasureRow& r : sheet.rows) mean += r.weight * r.points.value_or(0) / weights;
  if (row.weight > 0) figure.lost = 100 * row.weight * (1 - row.points.value_or(0)) / weights;
  // As in FindLosses(): total = 100 x cut_share x mean.
  if (key == "cut_share") figure.lost = 100 * (1 - row.value.value_or(0)) * mean;
  return figure;
}

/// Rounds the lost points so that they add up to those that the rounded total lacks: down, and then up where the most
/// was left over. Marks the figures by the points that they cost.
void RoundLosses(const ScoreSheet& sheet, double total, ReviewFigures& figures) {
  std::vector<ReviewFigure*> losing;
  int left = 100 - static_cast<int>(std::lround(total));
  for (auto* list : {&figures.first, &figures.rest}) {
    for (ReviewFigure& figure : *list) {
      if (!figure.lost || !(*figure.lost > 0)) continue;
      figure.lost_points = static_cast<int>(*figure.lost);
      left -= figure.lost_points;
      losing.push_back(&figure);
    }
  }
  std::stable_sort(losing.begin(), losing.end(), [](const ReviewFigure* a, const ReviewFigure* b) {
    return *a->lost - a->lost_points > *b->lost - b->lost_points;
  });
  for (ReviewFigure* figure : losing) {
    if (left-- > 0) ++figure->lost_points;
  }
  for (auto* list : {&figures.first, &figures.rest}) {
    for (ReviewFigure& figure : *list) {
      if (!figure.scored) continue;
      const MeasureRow& row = RowOf(sheet, figure.info->key);
      figure.level = ScoredLevel(figure.lost_points > 0, PointsOf(row));
      // What exceeds its goal reads so.
      const bool exceeds = figure.relation == GoalRelation::kAtMost && std::abs(row.value.value_or(0)) > row.goal;
      if (!exceeds || !figure.value) continue;
      while (figure.value->digits < 2 &&
             FormatQuantity(*figure.value) ==
                 FormatQuantity({figure.goal->value, figure.value->digits, figure.goal->unit})) {
        ++figure.value->digits;
        figure.goal->digits = figure.value->digits;
      }
    }
  }
}

bool Contains(const std::vector<const char*>& keys, std::string_view key) {
  return std::any_of(keys.begin(), keys.end(), [&](const char* k) { return key == k; });
}

/// Returns the keys of the figures to show first. Those that make no sense for the attempt are left out; those that
/// cost points stay.
std::vector<const char*> ChooseFigures(const ScoreSheet& sheet) {
  if (!sheet.kind) return {};
  const std::span<const char* const> all = KeyFiguresOf(*sheet.kind);
  if (sheet.total) return {all.begin(), all.end()};
  std::vector<const char*> keys;
  if (IsMostlyBeside(sheet)) keys.push_back("outside_mm3");
  for (const char* key : all) {
    const bool makes_sense = sheet.Get(key) && (!IsOfPlane(key) || IsPlaneSensible(sheet));
    if (makes_sense && !Contains(keys, key) && keys.size() < kReviewFigures) keys.push_back(key);
  }
  return keys;
}

/// Returns true if the measure says something about this attempt.
bool SaysSomething(const ScoreSheet& sheet, const MeasureRow& row) {
  const std::string_view key = row.info->key;
  if (sheet.total && row.weight > 0) return true;
  if (!row.value || (sheet.kind && !IsMeaningful(*row.info, *sheet.kind))) return false;
  if (IsOfPlane(key) && !IsPlaneSensible(sheet)) return false;
  // A sentence says what the planned cut did to the canal.
  if (key == "nerve_distance_mm" && sheet.kind && !SparesNerve(*sheet.kind) && *row.value < 0) return false;
  // The line was followed with the saw beside it.
  return key != "line_share" || !sheet.kind || !IsMostlyBeside(sheet);
}

}  // namespace

std::span<const char* const> KeyFiguresOf(ExerciseKind kind) {
  switch (kind) {
    case ExerciseKind::kGroove:
      return kGrooveFigures;
    case ExerciseKind::kStopBeforeFar:
      return kStopFigures;
    case ExerciseKind::kBicortical:
      return kThroughFigures;
    case ExerciseKind::kBesideCanal:
      return kCanalFigures;
    case ExerciseKind::kFollowLine:
      return kLineFigures;
    case ExerciseKind::kOsteotomy:
      return kOsteotomyFigures;
    case ExerciseKind::kDrillHoles:
      return kHoleFigures;
  }
  return {};
}

bool IsMeaningful(const MeasureInfo& info, ExerciseKind kind) {
  const std::string_view key = info.key;
  const auto begins = [&](std::string_view with) { return key.substr(0, with.size()) == with; };
  const bool holes = kind == ExerciseKind::kDrillHoles;
  if (begins("hole")) return holes;
  if (begins("plane") || begins("plunge_mean") || begins("plunges") || begins("line_share")) {
    if (holes) return false;
  }
  // The goal is a depth, or the far side of the bone.
  if (begins("depth_error") || begins("too_deep")) return !IsThrough(kind);
  if (begins("plunge")) return IsThrough(kind) || kind == ExerciseKind::kStopBeforeFar;
  // The other bones have no canal.
  if (begins("nerve") || begins("breach")) return SparesNerve(kind) || holes || kind == ExerciseKind::kOsteotomy;
  if (begins("near_miss")) return SparesNerve(kind);
  if (begins("feed_error")) return kind == ExerciseKind::kFollowLine;
  return true;
}

bool SparesNerve(ExerciseKind kind) {
  return kind == ExerciseKind::kBesideCanal;
}

const char* LabelOf(const MeasureInfo& info) {
  const Label* label = FindLabel(info.key);
  return label == nullptr ? info.name : label->text;
}

const char* MeaningOf(const MeasureInfo& info) {
  const Label* label = FindLabel(info.key);
  return label == nullptr ? info.formula : label->meaning;
}

Quantity ShowMeasure(const MeasureInfo& info, double value) {
  const Quantity shown = ShowRounded(info, value);
  const std::optional<double> perfect = PerfectOf(info);
  return perfect ? KeepFromPerfect(shown, *perfect) : shown;
}

std::string FormatGoal(const ReviewFigure& figure, std::string_view point) {
  if (!figure.goal) return {};
  const char* relation = figure.relation == GoalRelation::kAtMost    ? "≤ "
                         : figure.relation == GoalRelation::kAtLeast ? "≥ "
                                                                     : "";
  return relation + FormatQuantity(*figure.goal, point);
}

const MeasureRow& RowOf(const ScoreSheet& sheet, std::string_view key) {
  return *std::find_if(sheet.rows.begin(), sheet.rows.end(), [&](const MeasureRow& r) { return r.info->key == key; });
}

ReviewFigures MakeFigures(const ScoreSheet& sheet) {
  ReviewFigures figures;
  const std::vector<const char*> keys = ChooseFigures(sheet);
  for (const char* key : keys) figures.first.push_back(MakeFigure(sheet, RowOf(sheet, key)));
  for (const MeasureRow& row : sheet.rows) {
    if (!SaysSomething(sheet, row) || Contains(keys, row.info->key)) continue;
    figures.rest.push_back(MakeFigure(sheet, row));
  }
  if (sheet.total) RoundLosses(sheet, *sheet.total, figures);
  return figures;
}

}  // namespace kerf
