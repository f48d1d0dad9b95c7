#include "session/score/review.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace kerf {
namespace {

/// Loss of points below which a fault is not worth a sentence.
constexpr double kSmallLoss = 3;
/// Fraction of its points above which a measure is praised.
constexpr double kPraised = 0.8;
/// Fractions of the points from which a figure counts as good, and as fair.
constexpr double kGoodPoints = 0.7;
constexpr double kFairPoints = 0.4;
/// Fraction of the wanted cut from which it counts as good, and as fair.
constexpr double kGoodShare = 0.9;
constexpr double kFairShare = 0.6;
/// Fraction of the line from which an attempt is graded, and from which following it is praised.
constexpr double kFinishedShare = 0.8;
constexpr double kWholeLine = 0.95;
/// Distance from the nerve canal that is good, and that is fair.
constexpr double kNerveGood_mm = 2;
constexpr double kNerveFair_mm = 1;
/// Relative deviation from the wanted feed rate that is good, and that is fair.
constexpr double kFeedGood = 0.25;
constexpr double kFeedFair = 0.5;
/// Mean depth error from which a cut that is not too deep counts as too shallow.
constexpr double kShallow_mm = 0.15;
/// Smallest tremor that is shown with two decimals.
constexpr double kTrembles_mm = 0.005;
/// Fraction of the removed bone from which on an attempt is one beside the wanted cut.
constexpr double kMostlyBeside = 0.5;
/// A fitted plane is not that of the cut if it has more than this angle to the wanted one, or lies further away than
/// all removed bone by more than this.
constexpr double kMaxFitted_deg = 45;
constexpr double kBeyondCut_mm = 1;

struct Label {
  std::string_view key;
  const char* text;
};
constexpr std::array kLabels{
    Label{"cut_share", MarkMessage("Wanted cut made")},
    Label{"line_share", MarkMessage("Line followed")},
    Label{"depth_error_mean_mm", MarkMessage("Depth error, mean")},
    Label{"depth_error_p95_mm", MarkMessage("Depth error, 95 %")},
    Label{"depth_error_worst_mm", MarkMessage("Depth error, largest")},
    Label{"too_deep_mm", MarkMessage("Too deep by")},
    Label{"plunge_max_mm", MarkMessage("Plunge, largest")},
    Label{"plunge_mean_mm", MarkMessage("Plunge, mean")},
    Label{"plunges", MarkMessage("Plunges")},
    Label{"plane_offset_mm", MarkMessage("Beside the plan")},
    Label{"plane_roll_deg", MarkMessage("Lean to the side")},
    Label{"plane_yaw_deg", MarkMessage("Turn from the line")},
    Label{"plane_angle_deg", MarkMessage("Angle to the plan")},
    Label{"outside_mm3", MarkMessage("Removed outside")},
    Label{"removed_mm3", MarkMessage("Removed in total")},
    Label{"planned_mm3", MarkMessage("Planned volume")},
    Label{"under_mm3", MarkMessage("Left uncut")},
    Label{"dice", MarkMessage("Overlap (Dice)")},
    Label{"kerf_width_mm", MarkMessage("Width of the cut")},
    Label{"force_mean_N", MarkMessage("Force, mean")},
    Label{"force_peak_N", MarkMessage("Force, peak")},
    Label{"force_rms_N", MarkMessage("Force, RMS")},
    Label{"force_over_s", MarkMessage("Above force limit")},
    Label{"feed_mean_mm_per_s", MarkMessage("Feed, mean")},
    Label{"feed_cv", MarkMessage("Unevenness of feed")},
    Label{"sparc", MarkMessage("Smoothness (SPARC)")},
    Label{"jitter_mm", MarkMessage("Trembling")},
    Label{"time_total_s", MarkMessage("Time")},
    Label{"time_active_s", MarkMessage("Time in contact")},
    Label{"path_length_mm", MarkMessage("Path of the saw")},
    Label{"strokes", MarkMessage("Strokes")},
    Label{"nerve_distance_mm", MarkMessage("Distance to the nerve")},
    Label{"near_miss_s", MarkMessage("Time near the nerve")},
    Label{"breaches", MarkMessage("Cuts into the nerve")},
    Label{"breach_mm3", MarkMessage("Nerve canal removed")},
};

constexpr std::array kGrooveFigures{"plane_offset_mm", "plane_angle_deg", "too_deep_mm", "cut_share", "time_total_s"};
constexpr std::array kStopFigures{"too_deep_mm", "depth_error_mean_mm", "plane_offset_mm", "plane_angle_deg",
                                  "cut_share"};
constexpr std::array kThroughFigures{"plunge_max_mm", "plane_offset_mm", "plane_angle_deg", "cut_share",
                                     "time_total_s"};
constexpr std::array kCanalFigures{"nerve_distance_mm", "breach_mm3", "too_deep_mm", "plane_offset_mm", "cut_share"};
constexpr std::array kLineFigures{"plane_offset_mm", "plane_angle_deg", "jitter_mm", "feed_mean_mm_per_s", "cut_share"};
constexpr std::array kOsteotomyFigures{"plane_offset_mm", "plane_angle_deg", "cut_share", "outside_mm3",
                                       "time_total_s"};

bool IsThrough(ExerciseKind kind) {
  return kind == ExerciseKind::kBicortical || kind == ExerciseKind::kOsteotomy;
}

const MeasureRow& RowOf(const ScoreSheet& sheet, std::string_view key) {
  return *std::find_if(sheet.rows.begin(), sheet.rows.end(), [&](const MeasureRow& r) { return r.info->key == key; });
}

double Get(const ScoreSheet& sheet, std::string_view key) {
  return sheet.Get(key).value_or(0);
}

Quantity Show(const ScoreSheet& sheet, std::string_view key) {
  const MeasureInfo& info = FindMeasure(key);
  return ShowMeasure(info, std::abs(Get(sheet, key)));
}

bool IsBeside(const ScoreSheet& sheet) {
  return std::abs(Get(sheet, "plane_offset_mm")) > sheet.exercise.margin_mm;
}

/// Returns true if most of the removed bone lies beside the wanted cut, further from its plane than the margin.
bool IsMostlyBeside(const ScoreSheet& sheet) {
  return sheet.beside_mm && *sheet.beside_mm > sheet.exercise.margin_mm &&
         Get(sheet, "outside_mm3") >= kMostlyBeside * Get(sheet, "removed_mm3");
}

/// Returns false if the plane that was fitted to the removed bone cannot be that of the cut. Several cuts side by side
/// have no common plane.
bool IsPlaneSensible(const ScoreSheet& sheet) {
  return Get(sheet, "plane_angle_deg") <= kMaxFitted_deg &&
         (!sheet.farthest_mm || std::abs(Get(sheet, "plane_offset_mm")) <= *sheet.farthest_mm + kBeyondCut_mm);
}

bool IsOfPlane(std::string_view key) {
  return key.substr(0, 6) == "plane_";
}

/// Returns true if the cut stays above the wanted depth rather than below it.
bool IsShallow(const ScoreSheet& sheet) {
  return Get(sheet, "depth_error_mean_mm") > kShallow_mm &&
         Get(sheet, "depth_error_worst_mm") > Get(sheet, "too_deep_mm") + kShallow_mm;
}

/// Returns the fault that a lost point of a measure means.
Fault FaultOf(std::string_view key, bool beside, bool shallow) {
  if (key == "plane_offset_mm") return Fault::kBeside;
  if (key == "plane_angle_deg") return Fault::kTilted;
  if (key == "too_deep_mm") return Fault::kTooDeep;
  if (key == "plunge_max_mm") return Fault::kPlunge;
  if (key == "outside_mm3") return beside ? Fault::kBeside : Fault::kOutside;
  if (key == "near_miss_s" || key == "breaches" || key == "breach_mm3") return Fault::kNerve;
  if (key == "jitter_mm") return Fault::kTrembling;
  if (key == "path_length_mm") return Fault::kLongPath;
  if (key == "time_total_s") return Fault::kSlow;
  return beside ? Fault::kBeside : shallow ? Fault::kTooShallow : Fault::kMissing;
}

Message DescribeTilt(const ScoreSheet& sheet) {
  const bool leans = std::abs(Get(sheet, "plane_roll_deg")) >= std::abs(Get(sheet, "plane_yaw_deg"));
  if (leans) {
    return {
        "Your cut leans {} to the side. Check before you go into the bone that the blade stands in the wanted plane.",
        {Show(sheet, "plane_roll_deg")}};
  }
  return {MarkMessage(
              "Your cut is turned {} away from the line. Align the blade with the line before you go into the bone."),
          {Show(sheet, "plane_yaw_deg")}};
}

Message DescribeNerve(const ScoreSheet& sheet) {
  const Quantity depth{sheet.exercise.depth_mm, 1, "mm"};
  if (Get(sheet, "breach_mm3") > 0 || Get(sheet, "breaches") > 0) {
    return {MarkMessage("You cut into the nerve canal and removed {0} of it. Stop at a depth of {1}."),
            {Show(sheet, "breach_mm3"), depth}};
  }
  return {MarkMessage("The running blade was closer than {0} to the nerve canal for {1}. Stop at a depth of {2}."),
          {Quantity{kNerveGood_mm, 0, "mm"}, Show(sheet, "near_miss_s"), depth}};
}

/// Describes an attempt most of which lies beside the wanted cut.
Message DescribeMostlyBeside(const ScoreSheet& sheet) {
  const Quantity beside{sheet.beside_mm.value_or(0), 1, "mm"};
  if (*sheet.kind == ExerciseKind::kOsteotomy) {
    return {
        MarkMessage("You cut beside the planned plane, on average {} from it. Set the blade in the plane before you "
                    "go into the bone."),
        {beside}};
  }
  return {
      MarkMessage("You cut beside the line, on average {} from it. Set the blade on the line before you go into the "
                  "bone."),
      {beside}};
}

Message DescribeBeside(const ScoreSheet& sheet) {
  const Quantity offset = Show(sheet, "plane_offset_mm");
  switch (*sheet.kind) {
    case ExerciseKind::kGroove:
      return {
          MarkMessage("Your groove lies {} beside the line. Set the blade on the line before you go into the bone."),
          {offset}};
    case ExerciseKind::kOsteotomy:
      return {MarkMessage(
                  "Your cut lies {} beside the planned plane. Set the blade in the plane before you go into the bone."),
              {offset}};
    default:
      return {MarkMessage("Your cut lies {} beside the line. Set the blade on the line before you go into the bone."),
              {offset}};
  }
}

/// Returns a sentence that says how to avoid the fault.
Message DescribeFault(const ScoreSheet& sheet, Fault fault) {
  const Quantity depth{sheet.exercise.depth_mm, 1, "mm"};
  if ((fault == Fault::kBeside || fault == Fault::kTilted) && IsMostlyBeside(sheet) && !IsPlaneSensible(sheet)) {
    return DescribeMostlyBeside(sheet);
  }
  switch (fault) {
    case Fault::kBeside:
      if (sheet.Get("plane_offset_mm")) return DescribeBeside(sheet);
      return {MarkMessage("The place of your cut could not be measured. Cut along the whole line, to the full depth."),
              {}};
    case Fault::kTilted:
      if (sheet.Get("plane_angle_deg")) return DescribeTilt(sheet);
      return {
          MarkMessage("The direction of your cut could not be measured. Cut along the whole line, to the full depth."),
          {}};
    case Fault::kTooDeep:
      return {MarkMessage("You cut {0} too deep. Slow down before you reach the depth of {1}."),
              {Show(sheet, "too_deep_mm"), depth}};
    case Fault::kTooShallow:
      return {
          MarkMessage(
              "Your cut is {0} too shallow on average. Go on until the depth of {1} is reached along the whole line."),
          {Show(sheet, "depth_error_mean_mm"), depth}};
    case Fault::kPlunge:
      return {MarkMessage(
                  "The blade went {} beyond the far side of the bone. Push less as soon as you feel less resistance."),
              {Show(sheet, "plunge_max_mm")}};
    case Fault::kOutside:
      return {
          MarkMessage(
              "You removed {} beside the wanted cut. Move the blade only in its own plane while it is in the bone."),
          {Show(sheet, "outside_mm3")}};
    case Fault::kNerve:
      return DescribeNerve(sheet);
    case Fault::kTrembling:
      return {MarkMessage("The saw trembled by {} in the bone. Move it slowly and evenly, without stopping."),
              {Show(sheet, "jitter_mm")}};
    case Fault::kLongPath:
      return {MarkMessage("The saw moved {0}, and {1} are enough. Approach the line directly and follow it once."),
              {Show(sheet, "path_length_mm"),
               ShowMeasure(FindMeasure("path_length_mm"), 0.5 * RowOf(sheet, "path_length_mm").half)}};
    case Fault::kSlow:
      return {MarkMessage("You took {0}, and an unhurried cut takes {1}. Go on as soon as the spindle turns, and cut "
                          "without stopping."),
              {Show(sheet, "time_total_s"),
               ShowMeasure(FindMeasure("time_total_s"), 0.5 * RowOf(sheet, "time_total_s").half)}};
    case Fault::kMissing:
      break;
  }
  if (IsThrough(*sheet.kind)) {
    return {
        MarkMessage("You have cut {} of the wanted plane. Go on until the bone is cut through along the whole line."),
        {Show(sheet, "cut_share")}};
  }
  return {MarkMessage("You have made {0} of the wanted cut. Cut along the whole line, to the depth of {1}."),
          {Show(sheet, "cut_share"), depth}};
}

/// Returns a sentence about a measure that was good.
Message DescribeGood(const ScoreSheet& sheet, std::string_view key) {
  const Quantity value = Show(sheet, key);
  const bool none = FormatQuantity(value) == FormatQuantity({0, value.digits, value.unit});
  if (key == "too_deep_mm" && none) return {MarkMessage("Its depth is perfect: nowhere too deep."), {}};
  if (key == "plunge_max_mm" && none)
    return {MarkMessage("You stopped in time: the blade did not leave the far side."), {}};
  if (key == "outside_mm3" && none)
    return {MarkMessage("You spared the bone beside the cut: nothing was removed there."), {}};
  if (key == "plane_offset_mm") return {MarkMessage("Its place is right: only {} from the wanted plane."), {value}};
  if (key == "plane_angle_deg") return {MarkMessage("Its direction is right, within {}."), {value}};
  if (key == "too_deep_mm") return {MarkMessage("Its depth is right: nowhere more than {} too deep."), {value}};
  if (key == "plunge_max_mm") return {MarkMessage("You stopped in time: at most {} beyond the far side."), {value}};
  if (key == "outside_mm3")
    return {MarkMessage("You spared the bone beside the cut: only {} was removed there."), {value}};
  if (key == "near_miss_s" || key == "breaches" || key == "breach_mm3") {
    const std::optional<double> distance = sheet.Get("nerve_distance_mm");
    if (!distance) return {MarkMessage("You spared the nerve canal."), {}};
    return {MarkMessage("You spared the nerve canal: the blade stayed {} away from it."),
            {ShowMeasure(FindMeasure("nerve_distance_mm"), *distance)}};
  }
  if (key == "jitter_mm") return {MarkMessage("You held the saw steadily: it trembled by only {}."), {value}};
  if (key == "path_length_mm") return {MarkMessage("You moved the saw directly: its path was {}."), {value}};
  return {MarkMessage("You worked without haste and without delay: it took {}."), {value}};
}

std::optional<Message> FindPraise(const ScoreSheet& sheet) {
  const bool shallow = IsShallow(sheet);
  const MeasureRow* best = nullptr;
  for (const MeasureRow& row : sheet.rows) {
    if (row.weight == 0 || !row.value || row.points.value_or(0) < kPraised) continue;
    if (shallow && std::string_view(row.info->key) == "too_deep_mm") continue;  // it is not deep enough
    if (IsOfPlane(row.info->key) && !IsPlaneSensible(sheet)) continue;
    // Keys and simulated hands do not tremble.
    if (std::string_view(row.info->key) == "jitter_mm" && *row.value < kTrembles_mm) continue;
    if (best == nullptr || row.weight * *row.points > best->weight * *best->points) best = &row;
  }
  if (best != nullptr) return DescribeGood(sheet, best->info->key);
  if (Get(sheet, "line_share") >= kWholeLine) return Message{MarkMessage("You have followed the whole line."), {}};
  return {};
}

/// Returns the headline of an attempt without a total.
Message DescribeUngraded(const ScoreSheet& sheet) {
  if (!sheet.kind) return {MarkMessage("This recording is not an exercise, so it has no score."), {}};
  if (sheet.Get("removed_mm3") && Get(sheet, "removed_mm3") <= 0) {
    return {MarkMessage("Nothing was cut. Switch the spindle on and lower the blade into the bone on the line."), {}};
  }
  if (sheet.state == RecordingState::kWhole && sheet.incomplete.size() == 1 &&
      Get(sheet, "line_share") < kFinishedShare) {
    if (IsMostlyBeside(sheet)) return DescribeMostlyBeside(sheet);
    if (*sheet.kind == ExerciseKind::kOsteotomy) {
      return {MarkMessage("You have made {} of the planned cut. There is a score if you go on until the bone is cut "
                          "through."),
              {Show(sheet, "cut_share")}};
    }
    return {
        MarkMessage("You have made {0} of the wanted cut and followed {1} of the line; a score needs at least {2} of "
                    "the line. Cut along the whole line."),
        {Show(sheet, "cut_share"), Show(sheet, "line_share"), Quantity{100 * kFinishedShare, 0, "%"}}};
  }
  return {MarkMessage("This attempt is not graded: {}."), {sheet.incomplete.empty() ? "" : sheet.incomplete.front()}};
}

/// Returns what happened to a nerve canal that is not spared, because the planned plane crosses it.
std::optional<Message> DescribeCrossedNerve(const ScoreSheet& sheet) {
  if (!sheet.kind || SparesNerve(*sheet.kind) || !IsMeaningful(FindMeasure("nerve_distance_mm"), *sheet.kind))
    return {};
  if (Get(sheet, "breach_mm3") > 0 || Get(sheet, "breaches") > 0) {
    const Quantity removed = Show(sheet, "breach_mm3");
    if (FormatQuantity(removed) == FormatQuantity({0, removed.digits, removed.unit})) {
      return Message{
          MarkMessage("The running blade touched the nerve canal. The planned plane crosses the canal, so this "
                      "costs no points."),
          {}};
    }
    return Message{
        MarkMessage("The nerve canal was cut, and {} of it were removed. The planned plane crosses the canal, "
                    "so this costs no points."),
        {Show(sheet, "breach_mm3")}};
  }
  const std::optional<double> distance_mm = sheet.Get("nerve_distance_mm");
  if (!distance_mm) return {};
  return Message{
      MarkMessage("The blade came no nearer than {} to the nerve canal. The planned plane crosses the canal, "
                  "so its distance is not scored."),
      {ShowMeasure(FindMeasure("nerve_distance_mm"), std::max(*distance_mm, 0.0))}};
}

ReviewLevel LevelOf(bool good, bool fair) {
  return good ? ReviewLevel::kGood : fair ? ReviewLevel::kWarn : ReviewLevel::kBad;
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
    SetGoal(figure, GoalRelation::kEqual, 1);
    const double share = row.value.value_or(0);
    figure.level = LevelOf(share >= kGoodShare, share >= kFairShare);
  } else if (key == "nerve_distance_mm" && *sheet.kind == ExerciseKind::kBesideCanal) {
    SetGoal(figure, GoalRelation::kAtLeast, kNerveGood_mm);
    if (row.value) figure.level = LevelOf(*row.value >= kNerveGood_mm, *row.value >= kNerveFair_mm);
  } else if (key == "feed_mean_mm_per_s" && *sheet.kind == ExerciseKind::kFollowLine) {
    const double wanted = sheet.exercise.feed_mm_per_s;
    SetGoal(figure, GoalRelation::kEqual, wanted);
    const double error = std::abs(row.value.value_or(0) / wanted - 1);
    figure.level = LevelOf(error <= kFeedGood, error <= kFeedFair);
  } else if (key == "depth_error_mean_mm") {
    SetGoal(figure, GoalRelation::kEqual, 0);
    const double error_mm = std::abs(row.value.value_or(0));
    figure.level = LevelOf(error_mm <= 0.5 * sheet.exercise.margin_mm, error_mm <= sheet.exercise.margin_mm);
  } else if (row.weight > 0) {
    if (key == "time_total_s" || key == "path_length_mm") {
      SetGoal(figure, GoalRelation::kAtMost, 0.5 * row.half);
    } else {
      SetGoal(figure, GoalRelation::kEqual, 0);
    }
    const double points = row.value ? CalcPoints(*row.value, row.half) : 0;
    // Time and path cost points from the beginning, so that twice the goal is half of the points.
    const bool in_goal = figure.relation == GoalRelation::kAtMost && row.value && *row.value <= 0.5 * row.half;
    figure.level = LevelOf(points >= kGoodPoints || in_goal, points >= kFairPoints);
  }
  if (IsOfPlane(key) && !IsPlaneSensible(sheet)) figure.value.reset();
  if (!sheet.total) return figure;
  double weights = 0;
  double mean = 0;  // of the points
  for (const MeasureRow& r : sheet.rows) weights += r.weight;
  for (const MeasureRow& r : sheet.rows) mean += r.weight * r.points.value_or(0) / weights;
  if (row.weight > 0) figure.lost = 100 * row.weight * (1 - row.points.value_or(0)) / weights;
  // As in FindLosses(): total = 100 x cut_share x mean.
  if (key == "cut_share") figure.lost = 100 * (1 - row.value.value_or(0)) * mean;
  return figure;
}

/// Rounds the lost points so that they add up to those that the rounded total lacks: down, and then up where the most
/// was left over. A figure that costs points is not good.
void RoundLosses(double total, ExerciseReview& review) {
  std::vector<ReviewFigure*> losing;
  int left = 100 - static_cast<int>(std::lround(total));
  for (auto* list : {&review.figures, &review.rest}) {
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
    if (figure->lost_points == 0) continue;
    // What cost points differs visibly from the goal.
    if (figure->value && figure->goal && figure->relation == GoalRelation::kEqual) {
      const Quantity goal{figure->goal->value, figure->value->digits, figure->goal->unit};
      if (FormatQuantity(*figure->value) == FormatQuantity(goal)) ++figure->value->digits;
    }
    if (figure->level != ReviewLevel::kGood) continue;
    // Time and path cost points from the beginning, also within their goal.
    figure->level = figure->relation == GoalRelation::kAtMost ? ReviewLevel::kPlain : ReviewLevel::kWarn;
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
  }
  return {};
}

bool IsMeaningful(const MeasureInfo& info, ExerciseKind kind) {
  const std::string_view key = info.key;
  const auto begins = [&](std::string_view with) { return key.substr(0, with.size()) == with; };
  // The goal is a depth, or the far side of the bone.
  if (begins("depth_error") || begins("too_deep")) return !IsThrough(kind);
  if (begins("plunge")) return IsThrough(kind) || kind == ExerciseKind::kStopBeforeFar;
  // The other bones have no canal.
  if (begins("nerve") || begins("breach")) return SparesNerve(kind) || kind == ExerciseKind::kOsteotomy;
  if (begins("near_miss")) return SparesNerve(kind);
  return true;
}

bool SparesNerve(ExerciseKind kind) {
  return kind == ExerciseKind::kBesideCanal;
}

const char* LabelOf(const MeasureInfo& info) {
  const auto at = std::find_if(kLabels.begin(), kLabels.end(), [&](const Label& l) { return l.key == info.key; });
  return at == kLabels.end() ? info.name : at->text;
}

Quantity ShowMeasure(const MeasureInfo& info, double value) {
  const std::string_view key = info.key;
  const std::string_view unit = info.unit;
  if (key == "cut_share" || key == "line_share") return {100 * value, 0, "%"};
  if (key == "plunges" || key == "strokes" || key == "breaches") return {value, 0, ""};
  if (key == "jitter_mm") return {value, 2, "mm"};
  if (key == "path_length_mm") return {value, 0, "mm"};
  if (unit == "mm3") return {value, std::abs(value) < 10 ? 1 : 0, "mm³"};
  if (unit == "degrees") return {value, 1, "°"};
  if (unit == "s") return {value, std::abs(value) < 10 ? 1 : 0, "s"};
  if (unit.empty()) return {value, 2, ""};
  return {value, 1, info.unit};
}

std::string FormatGoal(const ReviewFigure& figure, std::string_view point) {
  if (!figure.goal) return {};
  const char* relation = figure.relation == GoalRelation::kAtMost    ? "≤ "
                         : figure.relation == GoalRelation::kAtLeast ? "≥ "
                                                                     : "";
  return relation + FormatQuantity(*figure.goal, point);
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
    add(FaultOf(row.info->key, beside, shallow), 100 * row.weight * (1 - points) / weights);
  }
  // total = 100 x cut_share x mean, so that this and the losses above add up to 100 - total.
  add(FaultOf("cut_share", beside, shallow), 100 * (1 - Get(sheet, "cut_share")) * mean);
  std::stable_sort(losses.begin(), losses.end(),
                   [](const FaultLoss& a, const FaultLoss& b) { return a.lost > b.lost; });
  return losses;
}

ExerciseReview MakeReview(const ScoreSheet& sheet) {
  ExerciseReview review;
  if (!sheet.total) {
    review.headline = DescribeUngraded(sheet);
  } else {
    const std::vector<FaultLoss> losses = FindLosses(sheet);
    review.headline = losses.empty() || losses.front().lost < kSmallLoss
                          ? Message{MarkMessage("An excellent cut: no single fault cost more than {} of 100 points."),
                                    {Quantity{kSmallLoss, 0, ""}}}
                          : DescribeFault(sheet, losses.front().fault);
    review.praise = FindPraise(sheet);
  }
  review.nerve = DescribeCrossedNerve(sheet);
  const std::vector<const char*> keys = ChooseFigures(sheet);
  for (const char* key : keys) review.figures.push_back(MakeFigure(sheet, RowOf(sheet, key)));
  for (const MeasureRow& row : sheet.rows) {
    if (!SaysSomething(sheet, row) || Contains(keys, row.info->key)) continue;
    review.rest.push_back(MakeFigure(sheet, row));
  }
  if (sheet.total) RoundLosses(*sheet.total, review);
  return review;
}

}  // namespace kerf
