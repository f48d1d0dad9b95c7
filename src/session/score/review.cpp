#include "session/score/review.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "session/score/faults.h"

namespace kerf {
namespace {

/// Loss of points below which a fault is not worth a sentence.
constexpr double kSmallLoss = 3;
/// Multiple of the wanted feed rate from which it is the reason for a cut that is too shallow.
constexpr double kTooFast = 1.5;
/// Multiple of the slowest feed along the line from which the fastest one makes it uneven.
constexpr double kUneven = 1.5;
/// Fraction of the time along the line from which a saw that was too slow, and also too fast, was uneven. A fast saw
/// needs little time for much of the line.
constexpr double kOftenWrong = 0.1;
/// Fraction of the time along the line from which resting is the reason for a feed that is too slow.
constexpr double kRestsMuch = 0.15;
/// Removed volume of the nerve canal below which it was only touched.
constexpr double kTouched_mm3 = 0.05;
/// Loss of points from which a fault is named before an injury outside the wanted cut.
constexpr double kWorseThanInjury = 10;
/// Total that is shown as 100 points.
constexpr double kAllPoints = 99.5;
/// Smallest tremor that is shown with two decimals.
constexpr double kTrembles_mm = 0.005;
/// Mean lack of depth on the deep stretch up to which the cut stopped early rather than being too shallow.
constexpr double kDeep_mm = 0.15;

Quantity Show(const ScoreSheet& sheet, std::string_view key) {
  const MeasureInfo& info = FindMeasure(key);
  return ShowMeasure(info, std::abs(GetOrZero(sheet, key)));
}

Message DescribeTilt(const ScoreSheet& sheet) {
  const bool leans = std::abs(GetOrZero(sheet, "plane_roll_deg")) >= std::abs(GetOrZero(sheet, "plane_yaw_deg"));
  if (leans) {
    return {MarkMessage("Your cut leans {} to the side. Check before you go into the bone that the blade stands in the "
                        "wanted plane."),
            {Show(sheet, "plane_roll_deg")}};
  }
  return {MarkMessage(
              "Your cut is turned {} away from the line. Align the blade with the line before you go into the bone."),
          {Show(sheet, "plane_yaw_deg")}};
}

Message DescribeNerve(const ScoreSheet& sheet) {
  const Quantity depth{sheet.exercise.depth_mm, 1, "mm"};
  if (GetOrZero(sheet, "breach_mm3") > 0 || GetOrZero(sheet, "breaches") > 0) {
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

/// Describes a cut that is deep enough, but not along the whole line; none: it is another one.
std::optional<Message> DescribeStopped(const ScoreSheet& sheet) {
  if (!sheet.deep || sheet.deep->share >= kWholeCut || sheet.deep->shallow_mm > kDeep_mm) return {};
  const Quantity share{100 * sheet.deep->share, 0, "%"};
  if (sheet.deep->from_start && !sheet.deep->goes_on) {
    return Message{
        MarkMessage(
            "You stopped at {0} of the line, and {1} of the wanted cut is made. Your depth is right there: go on "
            "to the end of the line."),
        {share, Show(sheet, "cut_share")}};
  }
  return Message{
      sheet.strokes
          ? MarkMessage("Only {0} of the line is as deep as wanted, and {1} of the wanted cut is made. Your depth is "
                        "right there: plunge the blade in again beside it, up to both ends of the line.")
          : MarkMessage("Only {0} of the line is as deep as wanted, and {1} of the wanted cut is made. Your depth is "
                        "right there: cut from one end of the line to the other."),
      {share, Show(sheet, "cut_share")}};
}

Message DescribeFeed(const ScoreSheet& sheet) {
  const Quantity wanted{sheet.exercise.feed_mm_per_s, 1, "mm/s"};
  if (!sheet.feed_along) {
    return {
        MarkMessage("Your feed could not be measured; {} are wanted. Go down to the depth at one end of the line, and "
                    "then move along it."),
        {wanted}};
  }
  const FeedAlong& along = *sheet.feed_along;
  const Quantity mean{along.mean_mm_per_s, 1, "mm/s"};
  const Quantity fastest{along.fastest_mm_per_s, 1, "mm/s"};
  const Quantity slowest{along.slowest_mm_per_s, 1, "mm/s"};
  Message uneven{
      MarkMessage("Your feed was uneven: at most {0} and at least {1} along the line, and a constant {2} is wanted. "
                  "Hold the key along the line without pauses; the [ and ] keys change its speed."),
      {fastest, slowest, wanted}};
  if (std::min(along.slow_share, along.fast_share) >= kOftenWrong) return uneven;
  // The saw was too slow or too fast for most of the time in which its feed was not right.
  if (along.slow_share > along.fast_share && along.mean_mm_per_s < (1 - kFeedGood) * wanted.value) {
    if (along.rest_share >= kRestsMuch) {
      return {
          MarkMessage("Your feed was too slow: {0} on average, and {1} are wanted. The saw rested for {2} of the time "
                      "along the line: keep moving it."),
          {mean, wanted, Quantity{100 * along.rest_share, 0, "%"}}};
    }
    if (along.slow_force_N >= kPressed_N) {
      return {
          MarkMessage("Your feed was too slow: {0} on average, and {1} are wanted. You pressed with {2}: press less."),
          {mean, wanted, Quantity{along.slow_force_N, 0, "N"}}};
    }
    return {MarkMessage("Your feed was too slow: {0} on average, and {1} are wanted. Move the saw faster: press the ] "
                        "key."),
            {mean, wanted}};
  }
  if (along.fast_share > along.slow_share && along.mean_mm_per_s > (1 + kFeedGood) * wanted.value) {
    return {
        MarkMessage("Your feed was too fast: {0} on average, and {1} are wanted. Move the saw more slowly: press the [ "
                    "key."),
        {mean, wanted}};
  }
  if (fastest.value > kUneven * slowest.value) return uneven;
  return {
      fastest.value > wanted.value
          ? MarkMessage("Your feed was {0} to {1} along the line, and {2} are wanted. Move more slowly: press the [ "
                        "key.")
          : MarkMessage("Your feed was {0} to {1} along the line, and {2} are wanted. Move faster: press the ] key."),
      {slowest, fastest, wanted}};
}

/// Returns a sentence on a fault in drilling that says how to avoid it; none: the fault is not one of holes.
std::optional<Message> DescribeHoleFault(const ScoreSheet& sheet, Fault fault) {
  if (*sheet.kind != ExerciseKind::kDrillHoles) return {};
  switch (fault) {
    case Fault::kBeside:
      return Message{MarkMessage("A hole lies {} beside its place. Set the tip of the drill on the place before you "
                                 "press."),
                     {Show(sheet, "hole_offset_mm")}};
    case Fault::kTilted:
      return Message{MarkMessage("A hole is tilted by {}. Check the direction of the drill before you press."),
                     {Show(sheet, "hole_angle_deg")}};
    case Fault::kPlunge:
      return Message{
          MarkMessage("The tip of the drill went {0} beyond the far side of the bone, and {1} are enough. Push less as "
                      "soon as you feel less resistance."),
          {Show(sheet, "plunge_max_mm"),
           ShowMeasure(FindMeasure("plunge_max_mm"), RowOf(sheet, "plunge_max_mm").goal)}};
    case Fault::kMissing:
      return Message{MarkMessage("You have drilled {} of the wanted holes. Go on until each is as deep as wanted."),
                     {Show(sheet, "cut_share")}};
    default:
      return {};
  }
}

/// Returns a sentence that says how to avoid the fault.
Message DescribeFault(const ScoreSheet& sheet, Fault fault) {
  if (std::optional<Message> of_holes = DescribeHoleFault(sheet, fault)) return *std::move(of_holes);
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
      if (sheet.through_mm) {
        return {
            MarkMessage("You cut right through the bone, which is {0} thick here: {1} too deep. Slow down before you "
                        "reach the depth of {2}."),
            {Quantity{*sheet.through_mm, 1, "mm"}, Show(sheet, "too_deep_mm"), depth}};
      }
      return {MarkMessage("You cut {0} too deep. Slow down before you reach the depth of {1}."),
              {Show(sheet, "too_deep_mm"), depth}};
    case Fault::kTooShallow:
      if (const std::optional<Message> stopped = DescribeStopped(sheet)) return *stopped;
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
          {ShowMeasure(FindMeasure("outside_mm3"), CalcBeside_mm3(sheet))}};
    case Fault::kBeyondEnd:
      if (*sheet.kind == ExerciseKind::kOsteotomy) {
        return {MarkMessage("You removed {} beyond the edges of the planned cut. Stop where the planned cut ends."),
                {ShowMeasure(FindMeasure("outside_mm3"), sheet.beyond_mm3)}};
      }
      return {MarkMessage("You removed {} beyond the ends of the line. Stop where the line ends."),
              {ShowMeasure(FindMeasure("outside_mm3"), sheet.beyond_mm3)}};
    case Fault::kNerve:
      return DescribeNerve(sheet);
    case Fault::kTrembling:
      return {MarkMessage("The saw trembled by {} in the bone. Move it slowly and evenly, without stopping."),
              {Show(sheet, "jitter_mm")}};
    case Fault::kLongPath:
      return {MarkMessage("The saw moved {0}, and {1} are enough. Approach the line directly and follow it once."),
              {Show(sheet, "path_length_mm"),
               ShowMeasure(FindMeasure("path_length_mm"), RowOf(sheet, "path_length_mm").goal)}};
    case Fault::kSlow:
      return {
          MarkMessage("You took {0}, and an unhurried cut takes {1}. Go on as soon as the spindle turns, and cut "
                      "without stopping."),
          {Show(sheet, "time_total_s"), ShowMeasure(FindMeasure("time_total_s"), RowOf(sheet, "time_total_s").goal)}};
    case Fault::kFeed:
      return DescribeFeed(sheet);
    case Fault::kMissing:
      if (const std::optional<Message> stopped = DescribeStopped(sheet)) return *stopped;
      break;
  }
  if (*sheet.kind == ExerciseKind::kOsteotomy) {
    return {MarkMessage("You have cut {} of the planned plane. Go on until the bone is cut through."),
            {Show(sheet, "cut_share")}};
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
  if (key == "too_deep_mm" && none) return {MarkMessage("The depth of your cut is perfect: nowhere too deep."), {}};
  if (key == "plunge_max_mm" && none)
    return {MarkMessage("You stopped in time: the blade did not leave the far side."), {}};
  if (key == "outside_mm3" && none)
    return {MarkMessage("You spared the bone beside the cut: nothing was removed there."), {}};
  if (key == "plane_offset_mm" && none)
    return {MarkMessage("The place of your cut is exact: it lies in the wanted plane."), {}};
  if (key == "plane_offset_mm")
    return {MarkMessage("The place of your cut is right: only {} from the wanted plane."), {value}};
  if (key == "plane_angle_deg" && none) return {MarkMessage("The direction of your cut is exact."), {}};
  if (key == "plane_angle_deg") return {MarkMessage("The direction of your cut is right, within {}."), {value}};
  if (key == "hole_offset_mm") return {MarkMessage("Each hole is at its place, within {}."), {value}};
  if (key == "hole_angle_deg") return {MarkMessage("Each hole has its direction, within {}."), {value}};
  if (key == "too_deep_mm")
    return {MarkMessage("The depth of your cut is right: nowhere more than {} too deep."), {value}};
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
  if (key == "feed_error") return {MarkMessage("Your feed was right, within {} on average."), {value}};
  if (key == "path_length_mm") return {MarkMessage("You moved the saw directly: its path was {}."), {value}};
  return {MarkMessage("You worked without haste and without delay: it took {}."), {value}};
}

/// Returns what is praised: neither a measure that cost points nor one of the fault in the headline.
std::optional<Message> FindPraise(const ScoreSheet& sheet, const ExerciseReview& review, std::optional<Fault> named) {
  const bool shallow = IsShallow(sheet);
  const auto costs = [&](const MeasureRow& row) {
    for (const auto* list : {&review.figures, &review.rest}) {
      for (const ReviewFigure& figure : *list) {
        if (figure.info == row.info) return figure.lost_points > 0 || figure.level != ReviewLevel::kGood;
      }
    }
    return false;
  };
  const MeasureRow* best = nullptr;
  for (const MeasureRow& row : sheet.rows) {
    if (row.weight == 0 || !row.value || costs(row)) continue;
    if (named && FaultOf(row.info->key, IsBeside(sheet), shallow) == *named) continue;
    if (shallow && std::string_view(row.info->key) == "too_deep_mm") continue;  // it is not deep enough
    if (IsOfPlane(row.info->key) && !IsPlaneSensible(sheet)) continue;
    // Keys and simulated hands do not tremble.
    if (std::string_view(row.info->key) == "jitter_mm" && *row.value < kTrembles_mm) continue;
    if (best == nullptr || row.weight * *row.points > best->weight * *best->points) best = &row;
  }
  if (best != nullptr) return DescribeGood(sheet, best->info->key);
  // The disc reaches half of the depth ahead of its lowest point, so that line_share alone does not tell.
  if (named != Fault::kMissing && std::min(GetOrZero(sheet, "line_share"), GetOrZero(sheet, "cut_share")) >= kWholeCut)
    return Message{MarkMessage("You have followed the whole line."), {}};
  return {};
}

/// Describes an attempt along the line that did not reach half of the wanted depth.
Message DescribeNotDeep(const ScoreSheet& sheet) {
  const Quantity reached{sheet.depth_mm.value_or(0), 1, "mm"};
  const Quantity wanted{sheet.exercise.depth_mm, 1, "mm"};
  if (sheet.strokes) {
    return {
        MarkMessage("Your cut is too shallow to be scored: it is {0} deep on average, and {1} are wanted. Press the "
                    "blade straight down to the depth at each place, and lift it out before you go on to the next."),
        {reached, wanted}};
  }
  const double feed_mm_per_s = GetOrZero(sheet, "feed_mean_mm_per_s");
  if (feed_mm_per_s > kTooFast * sheet.exercise.feed_mm_per_s) {
    return {
        MarkMessage("Your cut is too shallow to be scored: it is {0} deep on average, and {1} are wanted. You were "
                    "too fast, at {2}; {3} are wanted. Go to the depth first, and then move slowly along the line."),
        {reached, wanted, Quantity{feed_mm_per_s, 1, "mm/s"}, Quantity{sheet.exercise.feed_mm_per_s, 1, "mm/s"}}};
  }
  return {MarkMessage("Your cut is too shallow to be scored: it is {0} deep on average, and {1} are wanted. Go to the "
                      "depth first, and keep pressing down while you move along the line."),
          {reached, wanted}};
}

/// Returns true if an attempt is not graded only because too little of the line was cut.
bool IsUnfinished(const ScoreSheet& sheet) {
  return sheet.kind && sheet.state == RecordingState::kWhole && sheet.incomplete.size() == 1 &&
         GetOrZero(sheet, "line_share") < kFinishedShare;
}

/// Returns why an unfinished attempt has no score.
std::optional<Message> DescribeNoScore(const ScoreSheet& sheet) {
  if (!IsUnfinished(sheet) || *sheet.kind == ExerciseKind::kDrillHoles || !(GetOrZero(sheet, "removed_mm3") > 0))
    return {};
  return Message{
      *sheet.kind == ExerciseKind::kOsteotomy
          ? MarkMessage(
                "There is no score, because the blade reached half of the planned depth along {0} of the plane's "
                "width; {1} are needed.")
          : MarkMessage("There is no score, because the blade reached half of the wanted depth along {0} of the line; "
                        "{1} are needed."),
      {Show(sheet, "line_share"), Quantity{100 * kFinishedShare, 0, "%"}}};
}

/// Returns the headline of an attempt without a total.
Message DescribeUngraded(const ScoreSheet& sheet) {
  if (!sheet.kind) return {MarkMessage("This recording is not an exercise, so it has no score."), {}};
  if (sheet.Get("removed_mm3") && GetOrZero(sheet, "removed_mm3") <= 0) {
    if (sheet.turned) return {MarkMessage("Nothing was cut. Lower the turning blade into the bone on the line."), {}};
    return {MarkMessage("Nothing was cut. Switch the spindle on and lower the blade into the bone on the line."), {}};
  }
  if (IsUnfinished(sheet)) {
    if (const auto of_holes = DescribeHoleFault(sheet, Fault::kMissing)) return *of_holes;
    if (IsMostlyBeside(sheet)) return DescribeMostlyBeside(sheet);
    if (*sheet.kind == ExerciseKind::kOsteotomy) {
      return {
          MarkMessage("You have made {} of the planned cut. For a score, cut until the bone is cut through before you "
                      "finish."),
          {Show(sheet, "cut_share")}};
    }
    if (sheet.begun_share.value_or(0) >= kFinishedShare) return DescribeNotDeep(sheet);
    return {MarkMessage("You have made {} of the wanted cut. Cut along the whole line, to the full depth."),
            {Show(sheet, "cut_share")}};
  }
  return {MarkMessage("This attempt is not graded: {}."), {sheet.incomplete.empty() ? "" : sheet.incomplete.front()}};
}

/// Returns what else the student should know about the attempt.
std::vector<Message> FindNotes(const ScoreSheet& sheet) {
  std::vector<Message> notes;
  if (!sheet.kind) return notes;
  const double limit_s = sheet.exercise.time_limit_s;
  if (limit_s > 0 && GetOrZero(sheet, "time_total_s") >= limit_s) {
    notes.push_back({MarkMessage("The time was up: the attempt ended after {}."), {Quantity{limit_s, 0, "s"}}});
  }
  if ((!sheet.total || sheet.through_mm) && IsMeaningful(FindMeasure("too_deep_mm"), *sheet.kind) &&
      GetOrZero(sheet, "too_deep_mm") > sheet.exercise.margin_mm) {
    notes.push_back(DescribeFault(sheet, Fault::kTooDeep));
  }
  if (std::optional<Message> why = DescribeNoScore(sheet)) notes.push_back(std::move(*why));
  return notes;
}

bool IsCanal(const StructureResult& structure) {
  return structure.kind == MarkKind::kNerve || structure.kind == MarkKind::kCanal;
}

/// Returns what a planned cut did to the nerve canal, and how far the planned planes are from it.
std::optional<Message> DescribeNerveOfPlan(const ScoreSheet& sheet) {
  if (sheet.kind != ExerciseKind::kOsteotomy || !sheet.plan_nerve_mm) return {};
  const bool crosses = *sheet.plan_nerve_mm <= 0;
  const Quantity plan{*sheet.plan_nerve_mm, 1, "mm"};
  // What was removed outside the plan is named as an injury.
  double breach_mm3 = GetOrZero(sheet, "breach_mm3");
  for (const OutsideInjury& injury : sheet.injured) {
    if (IsCanal(injury.structure)) breach_mm3 -= injury.structure.removed_mm3;
  }
  if (breach_mm3 > 0 || GetOrZero(sheet, "breaches") > 0) {
    const Quantity removed = ShowMeasure(FindMeasure("breach_mm3"), breach_mm3);
    if (!crosses && breach_mm3 < kTouched_mm3) {
      return Message{
          MarkMessage("The running blade touched the nerve canal. The planned cut passes {} from the canal."), {plan}};
    }
    if (!crosses) {
      return Message{sheet.canal_severed
                         ? MarkMessage("The nerve canal was severed, and {0} of it were removed. The planned cut "
                                       "passes {1} from the canal.")
                         : MarkMessage("The nerve canal was injured, and {0} of it were removed. The planned cut "
                                       "passes {1} from the canal."),
                     {removed, plan}};
    }
    if (breach_mm3 < kTouched_mm3) {
      return Message{
          MarkMessage("The running blade touched the nerve canal. The planned plane crosses the canal, so this "
                      "costs no points."),
          {}};
    }
    return Message{
        sheet.canal_severed
            ? MarkMessage(
                  "The nerve canal was severed, and {} of it were removed. The planned plane crosses the canal, "
                  "so this costs no points.")
            : MarkMessage(
                  "The nerve canal was injured, and {} of it were removed. The planned plane crosses the canal, "
                  "so this costs no points."),
        {removed}};
  }
  const std::optional<double> distance_mm = sheet.Get("nerve_distance_mm");
  if (!distance_mm) return {};
  const Quantity nearest = ShowMeasure(FindMeasure("nerve_distance_mm"), std::max(*distance_mm, 0.0));
  if (!crosses) {
    return Message{MarkMessage("The blade came no nearer than {0} to the nerve canal. The planned cut passes {1} from "
                               "the canal."),
                   {nearest, plan}};
  }
  return Message{
      MarkMessage("The blade came no nearer than {} to the nerve canal. The planned plane crosses the canal, "
                  "so its distance is not scored."),
      {nearest}};
}

/// Returns a sentence for each structure that was injured outside the wanted cut. A nerve that must be spared is
/// scored, and named as a fault.
std::vector<Message> DescribeInjuries(const ScoreSheet& sheet) {
  std::vector<Message> lines;
  for (const auto& [structure, away_mm] : sheet.injured) {
    if (!sheet.kind || (IsCanal(structure) && SparesNerve(*sheet.kind))) continue;
    lines.push_back(
        {*sheet.kind == ExerciseKind::kOsteotomy
             ? MarkMessage("You injured a structure outside the plan: {0}. {1} of it were removed, {2} from the plan.")
             : MarkMessage("You injured a structure outside the wanted cut: {0}. {1} of it were removed, {2} from the "
                           "wanted cut."),
         {FormatMessage(NameStructure(structure)), ShowMeasure(FindMeasure("outside_mm3"), structure.removed_mm3),
          Quantity{away_mm, 1, "mm"}}});
  }
  return lines;
}

/// Returns a sentence for each structure other than the nerve canal that was cut as planned.
std::vector<Message> DescribeCrossed(const ScoreSheet& sheet) {
  std::vector<Message> lines;
  for (const StructureResult& structure : sheet.crossed) {
    if (IsCanal(structure)) continue;
    lines.push_back(
        {MarkMessage("Crossed by the plan: {0}. {1} of it were removed, which costs no points."),
         {FormatMessage(NameStructure(structure)), ShowMeasure(FindMeasure("outside_mm3"), structure.removed_mm3)}});
  }
  return lines;
}

}  // namespace

ExerciseReview MakeReview(const ScoreSheet& sheet) {
  ExerciseReview review;
  std::optional<Fault> named;
  double named_loss = kWorseThanInjury;  // without a score, the reason for that is named first
  if (!sheet.total) {
    review.headline = DescribeUngraded(sheet);
  } else {
    const std::vector<FaultLoss> losses = FindLosses(sheet);
    named_loss = losses.empty() ? 0 : losses.front().lost;
    if (named_loss >= kSmallLoss) named = losses.front().fault;
    review.headline = named                    ? DescribeFault(sheet, *named)
                      : !sheet.crossed.empty() ? Message{MarkMessage("The cut follows its plan, and injures what an "
                                                                     "operation spares where it can, as named "
                                                                     "below."),
                                                         {}}
                      : *sheet.total >= kAllPoints ? Message{MarkMessage("An excellent cut: no points were lost."), {}}
                                                   : Message{MarkMessage("An excellent cut: no single fault cost more "
                                                                         "than {} of 100 points."),
                                                             {Quantity{kSmallLoss, 0, ""}}};
    if (sheet.level > 0 && *sheet.total >= kGoodTotal && !IsNotThrough(*sheet.kind, GetOrZero(sheet, "cut_share"))) {
      review.passed = Message{MarkMessage("Level {0} is passed with {1} of 100 points."),
                              {Quantity{static_cast<double>(sheet.level), 0, ""}, Quantity{*sheet.total, 0, ""}}};
    }
  }
  review.notes = DescribeInjuries(sheet);
  const bool injury_is_worst = !review.notes.empty() && named_loss < kWorseThanInjury;
  for (Message& note : FindNotes(sheet)) review.notes.push_back(std::move(note));
  if (injury_is_worst) {
    std::swap(review.headline, review.notes.front());
    if (!named) review.notes.erase(review.notes.begin());  // the cut was not excellent
  }
  std::erase(review.notes, review.headline);
  review.nerve = DescribeNerveOfPlan(sheet);
  review.crossed = DescribeCrossed(sheet);
  ReviewFigures figures = MakeFigures(sheet);
  review.figures = std::move(figures.first);
  review.rest = std::move(figures.rest);
  if (sheet.total) review.praise = FindPraise(sheet, review, named);
  return review;
}

}  // namespace kerf
