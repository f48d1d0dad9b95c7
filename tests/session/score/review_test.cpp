// Tests of the advice after an attempt.
#include "session/score/review.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "session/score/faults.h"

namespace kerf {
namespace {

using testing::HasSubstr;

constexpr ExerciseKind kReviewed[] = {ExerciseKind::kGroove,     ExerciseKind::kStopBeforeFar,
                                      ExerciseKind::kBicortical, ExerciseKind::kBesideCanal,
                                      ExerciseKind::kFollowLine, ExerciseKind::kOsteotomy};

/// Returns the sheet of a complete and perfect cut.
ScoreSheet PerfectSheet(ExerciseKind kind) {
  ScoreSheet sheet = MakeSheet(kind);
  sheet.exercise.given = true;
  sheet.exercise.kind = kind;
  sheet.exercise.depth_mm = 2;
  sheet.exercise.margin_mm = 0.5;
  for (MeasureRow& row : sheet.rows) {
    row.value = 0;
    if (row.half == 0) row.half = 10;
    const std::string_view key = row.info->key;
    if (key == "time_total_s" || key == "path_length_mm") row.goal = 5;
    if (key == "feed_error") row.goal = kFeedGood;
  }
  for (const char* key : {"cut_share", "line_share"}) SetValue(sheet, key, 1);
  SetValue(sheet, "feed_mean_mm_per_s", sheet.exercise.feed_mm_per_s);
  SetValue(sheet, "removed_mm3", 12);
  SetValue(sheet, "nerve_distance_mm", 2.6);
  CalcTotal(sheet);
  return sheet;
}

std::string Headline(ScoreSheet sheet) {
  CalcTotal(sheet);
  return FormatMessage(MakeReview(sheet).headline);
}

/// Returns the number of characters of UTF-8.
std::size_t Length(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

TEST(Review, GrooveBesideTheLineIsTheFirstThingSaid) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  SetValue(sheet, "plane_offset_mm", -3.1);
  SetValue(sheet, "cut_share", 0);  // nothing within the margin was cut
  SetValue(sheet, "outside_mm3", 12);
  CalcTotal(sheet);
  const ExerciseReview review = MakeReview(sheet);
  EXPECT_EQ(FormatMessage(review.headline),
            "Your groove lies 3.1 mm beside the line. Set the blade on the line before you go into the bone.");
  ASSERT_TRUE(review.praise);
  EXPECT_EQ(FormatMessage(*review.praise), "The depth of your cut is perfect: nowhere too deep.");
}

TEST(Review, HeadlineNamesTheFaultThatCostsMost) {
  struct FaultCase {
    ExerciseKind kind;
    const char* key;
    double value;
    const char* words;
  };
  const FaultCase cases[] = {
      {ExerciseKind::kGroove, "too_deep_mm", 1.4, "1.4 mm too deep"},
      {ExerciseKind::kGroove, "plane_angle_deg", 6, "leans"},
      {ExerciseKind::kGroove, "outside_mm3", 12, "12 mm³ beside the wanted cut"},
      {ExerciseKind::kGroove, "jitter_mm", 0.25, "trembled by 0.25 mm"},
      {ExerciseKind::kGroove, "path_length_mm", 30, "moved 30 mm, and 5 mm are enough"},
      {ExerciseKind::kGroove, "time_total_s", 30, "took 30 s, and an unhurried cut takes 5.0 s"},
      {ExerciseKind::kGroove, "cut_share", 0.7, "made 70 % of the wanted cut"},
      {ExerciseKind::kBicortical, "plunge_max_mm", 7, "went 7.0 mm beyond the far side"},
      {ExerciseKind::kBicortical, "cut_share", 0.7, "cut 70 % of the wanted plane"},
      {ExerciseKind::kBesideCanal, "near_miss_s", 9, "closer than 2 mm to the nerve canal for 9.0 s"},
      {ExerciseKind::kBesideCanal, "breach_mm3", 3, "removed 3.0 mm³ of it"},
      {ExerciseKind::kFollowLine, "plane_offset_mm", 0.9, "0.9 mm beside the line"},
      {ExerciseKind::kOsteotomy, "plane_offset_mm", 2.5, "2.5 mm beside the planned plane"},
  };
  for (const FaultCase& c : cases) {
    ScoreSheet sheet = PerfectSheet(c.kind);
    SetValue(sheet, c.key, c.value);
    if (std::string(c.key) == "plane_angle_deg") SetValue(sheet, "plane_roll_deg", -c.value);
    EXPECT_THAT(Headline(sheet), HasSubstr(c.words)) << c.key;
  }
  ScoreSheet turned = PerfectSheet(ExerciseKind::kGroove);
  SetValue(turned, "plane_angle_deg", 6);
  SetValue(turned, "plane_yaw_deg", -6);
  EXPECT_THAT(Headline(turned), HasSubstr("turned 6.0° away from the line"));
}

TEST(Review, NamesAToothThatWasInjuredOutsideTheWantedCut) {
  const std::string tooth =
      "You injured a structure outside the plan: tooth 2 from the middle, patient's left. 13 mm³ of it were removed, "
      "9.6 "
      "mm from the plan.";
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  sheet.injured = {{.structure = {.kind = MarkKind::kTooth, .side = BodySide::kLeft, .number = 2, .removed_mm3 = 13},
                    .away_mm = 9.6}};
  EXPECT_EQ(Headline(sheet), tooth);
  EXPECT_TRUE(MakeReview(sheet).notes.empty());
  // What costs more is named first.
  SetValue(sheet, "cut_share", 0.72);
  EXPECT_THAT(Headline(sheet), HasSubstr("72 % of the planned plane"));
  ASSERT_EQ(MakeReview(sheet).notes.size(), 1U);
  EXPECT_EQ(FormatMessage(MakeReview(sheet).notes.front()), tooth);
}

TEST(Review, NamesWhatThePlanCrossedApartFromWhatWasInjuredOutside) {
  const StructureResult tooth{.kind = MarkKind::kTooth, .side = BodySide::kLeft, .is_row = true};
  const StructureResult canal{.kind = MarkKind::kCanal, .side = BodySide::kLeft};
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  const auto with = [](StructureResult structure, double removed_mm3) {
    structure.removed_mm3 = removed_mm3;
    return structure;
  };
  sheet.crossed = {with(canal, 1.5), with(tooth, 10.4)};
  sheet.injured = {{.structure = with(tooth, 2.7), .away_mm = 6}, {.structure = with(canal, 1), .away_mm = 2}};
  SetValue(sheet, "breach_mm3", 2.5);
  sheet.plan_nerve_mm = -1;
  const ExerciseReview review = MakeReview(sheet);
  EXPECT_THAT(FormatMessage(review.headline),
              HasSubstr("outside the plan: row of touching teeth, patient's left. 2.7"));
  ASSERT_EQ(review.crossed.size(), 1U);
  EXPECT_EQ(
      FormatMessage(review.crossed[0]),
      "Crossed by the plan: row of touching teeth, patient's left. 10 mm³ of it were removed, which costs no points.");
  EXPECT_THAT(FormatMessage(review.nerve.value()), HasSubstr("1.5 mm³ of it were removed"));
}

TEST(Review, MissingBoneIsTooShallowWhereTheLineWasFollowed) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  SetValue(sheet, "cut_share", 0.6);
  SetValue(sheet, "depth_error_mean_mm", 0.8);
  SetValue(sheet, "depth_error_worst_mm", 1.1);
  EXPECT_THAT(Headline(sheet), HasSubstr("0.8 mm too shallow"));
  CalcTotal(sheet);
  // A cut that is too shallow is not praised for its depth.
  EXPECT_THAT(FormatMessage(*MakeReview(sheet).praise), testing::Not(HasSubstr("depth")));
}

TEST(Review, CutThatStopsEarlyAtTheRightDepthIsNotTooShallow) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  SetValue(sheet, "cut_share", 0.8);
  SetValue(sheet, "depth_error_mean_mm", 0.3);
  SetValue(sheet, "depth_error_worst_mm", 1.5);
  sheet.deep = DeepStretch{.share = 0.72, .from_start = true, .shallow_mm = 0.04};
  EXPECT_EQ(
      Headline(sheet),
      "You stopped at 72 % of the line, and 80 % of the wanted cut is made. Your depth is right there: go on to the "
      "end of the line.");
  const DeepStretch stopped = *sheet.deep;
  sheet.deep->goes_on = true;  // but less deeply
  EXPECT_THAT(Headline(sheet), HasSubstr("Only 72 % of the line is as deep as wanted"));
  sheet.deep = stopped;
  sheet.deep->from_start = false;
  EXPECT_THAT(Headline(sheet),
              HasSubstr("Only 72 % of the line is as deep as wanted, and 80 % of the wanted cut is made."));
  sheet.deep->shallow_mm = 0.25;
  EXPECT_THAT(Headline(sheet), HasSubstr("0.3 mm too shallow"));
  sheet.deep = DeepStretch{.share = 1, .from_start = true, .shallow_mm = 0.1};
  EXPECT_THAT(Headline(sheet), HasSubstr("0.3 mm too shallow"));
}

TEST(Review, FeedThatMissesTheGoalOfItsExerciseCostsPoints) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kFollowLine);
  EXPECT_THAT(Headline(sheet), HasSubstr("An excellent cut"));
  sheet.exercise.feed_mm_per_s = 3;
  SetValue(sheet, "feed_error", 0.7);
  sheet.feed_along = FeedAlong{0, 6.2, 3.1};
  EXPECT_EQ(Headline(sheet),
            "Your feed was uneven: at most 6.2 mm/s and at least 0.0 mm/s along the line, and a constant 3.0 mm/s is "
            "wanted. Hold the key along the line without pauses; the [ and ] keys change its speed.");
  sheet.feed_along = FeedAlong{4.8, 5.3, 3.7};
  EXPECT_EQ(
      Headline(sheet),
      "Your feed was 4.8 mm/s to 5.3 mm/s along the line, and 3.0 mm/s are wanted. Move more slowly: press the [ key.");
  sheet.feed_along = FeedAlong{1.2, 1.4, 2.4};
  EXPECT_EQ(
      Headline(sheet),
      "Your feed was 1.2 mm/s to 1.4 mm/s along the line, and 3.0 mm/s are wanted. Move faster: press the ] key.");
  CalcTotal(sheet);
  const ExerciseReview review = MakeReview(sheet);
  ASSERT_STREQ(review.figures[0].info->key, "feed_error");
  EXPECT_EQ(FormatQuantity(*review.figures[0].value), "70 %");
  EXPECT_EQ(FormatGoal(review.figures[0]), "\u2264 25 %");
  EXPECT_EQ(review.figures[0].level, ReviewLevel::kBad);
  // A cut that is perfect but for a feed far from the goal does not pass.
  SetValue(sheet, "feed_error", 2.3);
  CalcTotal(sheet);
  EXPECT_LT(*sheet.total, 70);
  // A feed that could not be measured scores nothing.
  SetValue(sheet, "feed_error", std::nullopt);
  sheet.feed_along.reset();
  EXPECT_THAT(Headline(sheet), HasSubstr("Your feed could not be measured"));
  // In the other exercises the feed is not a goal.
  ScoreSheet groove = PerfectSheet(ExerciseKind::kGroove);
  SetValue(groove, "feed_error", 2);
  EXPECT_THAT(Headline(groove), HasSubstr("An excellent cut"));
}

TEST(Review, LossesAddUpToWhatTheTotalLacks) {
  for (const ExerciseKind kind : kReviewed) {
    ScoreSheet sheet = PerfectSheet(kind);
    EXPECT_TRUE(FindLosses(sheet).empty());
    double value = 0.2;
    for (const Goal& goal : GoalsOf(kind)) SetValue(sheet, goal.key, value += 0.3);
    SetValue(sheet, "cut_share", 0.83);
    CalcTotal(sheet);
    double sum = 0;
    double last = 100;
    for (const FaultLoss& loss : FindLosses(sheet)) {
      EXPECT_LE(loss.lost, last);
      last = loss.lost;
      sum += loss.lost;
    }
    EXPECT_NEAR(sum, 100 - sheet.total.value(), 1e-9);  // rounding
  }
}

TEST(Review, ExcellentCutHasNoFault) {
  for (const ExerciseKind kind : kReviewed) {
    EXPECT_EQ(Headline(PerfectSheet(kind)), "An excellent cut: no points were lost.");
    EXPECT_TRUE(MakeReview(PerfectSheet(kind)).praise);
  }
}

TEST(Review, SaysWhyAnAttemptHasNoScore) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  sheet.incomplete = {"the exercise is not finished"};
  SetValue(sheet, "line_share", 0.45);
  SetValue(sheet, "cut_share", 0.28);
  EXPECT_EQ(Headline(sheet), "You have made 28 % of the wanted cut. Cut along the whole line, to the full depth.");
  ASSERT_EQ(MakeReview(sheet).notes.size(), 1);
  EXPECT_EQ(FormatMessage(MakeReview(sheet).notes[0]),
            "There is no score, because the blade reached half of the wanted depth along 45 % of the line; 80 % are "
            "needed.");
  // The same if the headline says that the cut lies beside the line.
  ScoreSheet beside = sheet;
  beside.beside_mm = 3;
  SetValue(beside, "removed_mm3", 12);
  SetValue(beside, "outside_mm3", 12);
  EXPECT_THAT(Headline(beside), HasSubstr("You cut beside the line"));
  EXPECT_EQ(MakeReview(beside).notes, MakeReview(sheet).notes);
  // What could not be measured is left out, and so is its cross.
  SetValue(sheet, "plane_offset_mm", std::nullopt);
  CalcTotal(sheet);
  EXPECT_EQ(MakeReview(sheet).figures.size(), kReviewFigures - 1);
  SetValue(sheet, "removed_mm3", 0);
  EXPECT_THAT(Headline(sheet), HasSubstr("Nothing was cut"));
  SetValue(sheet, "removed_mm3", 5);
  sheet.state = RecordingState::kCutShort;
  sheet.incomplete = {"the recording is cut short", "another reason"};
  EXPECT_EQ(Headline(sheet), "This attempt is not graded: the recording is cut short.");
  const ExerciseReview none = MakeReview(MakeSheet({}));
  EXPECT_THAT(FormatMessage(none.headline), HasSubstr("not an exercise"));
  EXPECT_TRUE(none.figures.empty());
}

TEST(Review, UnfinishedOsteotomySaysHowMuchIsCutAndNamesNoLine) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  sheet.incomplete = {"the exercise is not finished"};
  SetValue(sheet, "line_share", 0);
  SetValue(sheet, "cut_share", 0.28);
  EXPECT_EQ(Headline(sheet),
            "You have made 28 % of the planned cut. For a score, cut until the bone is cut through before you finish.");
  for (const Message& note : MakeReview(sheet).notes) {
    EXPECT_THAT(FormatMessage(note), testing::Not(HasSubstr("line"))) << FormatMessage(note);
  }
}

// Two grooves, 6 and 9 mm beside the line: they have no common plane, and the line was "followed" beside it.
TEST(Review, AttemptBesideTheLineSaysSoAndShowsNoFiguresWithoutSense) {
  const auto keys = [](const ExerciseReview& review) {
    std::set<std::string> found;
    for (const auto* list : {&review.figures, &review.rest}) {
      for (const ReviewFigure& figure : *list) found.insert(figure.info->key);
    }
    return found;
  };
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  sheet.incomplete = {"the exercise is not finished"};
  sheet.beside_mm = 7.5;
  sheet.farthest_mm = 9.5;
  SetValue(sheet, "line_share", 0.73);
  SetValue(sheet, "cut_share", 0);
  SetValue(sheet, "outside_mm3", 12);
  SetValue(sheet, "plane_offset_mm", 32.3);
  SetValue(sheet, "plane_angle_deg", 89.1);
  CalcTotal(sheet);
  const ExerciseReview review = MakeReview(sheet);
  EXPECT_EQ(
      FormatMessage(review.headline),
      "You cut beside the line, on average 7.5 mm from it. Set the blade on the line before you go into the bone.");
  const std::set<std::string> shown = keys(review);
  for (const char* key : {"plane_offset_mm", "plane_angle_deg", "plane_roll_deg", "line_share"}) {
    EXPECT_FALSE(shown.contains(key)) << key;
  }
  EXPECT_STREQ(review.figures.front().info->key, "outside_mm3");
  // A single groove has a plane, also beside the line.
  SetValue(sheet, "plane_offset_mm", 7.5);
  SetValue(sheet, "plane_angle_deg", 1);
  EXPECT_TRUE(keys(MakeReview(sheet)).contains("plane_offset_mm"));
  // A graded attempt keeps the figures that cost points, without the values that make no sense.
  sheet.incomplete.clear();
  SetValue(sheet, "cut_share", 0.5);
  SetValue(sheet, "plane_angle_deg", 89.1);
  CalcTotal(sheet);
  const ExerciseReview graded = MakeReview(sheet);
  EXPECT_THAT(FormatMessage(graded.headline), HasSubstr("on average 7.5 mm from it"));
  ASSERT_STREQ(graded.figures[0].info->key, "plane_offset_mm");
  EXPECT_FALSE(graded.figures[0].value);
  // An unfinished cut in the right place is not beside the line.
  sheet.beside_mm = 0.1;
  sheet.incomplete = {"the exercise is not finished"};
  EXPECT_THAT(Headline(sheet), HasSubstr("Cut along the whole line"));
}

TEST(Review, OsteotomyNamesTheNerveThatThePlaneCrosses) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  sheet.plan_nerve_mm = -1.4;
  ASSERT_TRUE(MakeReview(sheet).nerve);
  EXPECT_EQ(FormatMessage(*MakeReview(sheet).nerve),
            "The blade came no nearer than 2.6 mm to the nerve canal. The planned plane crosses the canal, so its "
            "distance is not scored.");
  SetValue(sheet, "breach_mm3", 3.3);
  SetValue(sheet, "breaches", 1);
  SetValue(sheet, "nerve_distance_mm", -1.2);
  const double total = sheet.total.value();
  CalcTotal(sheet);
  EXPECT_EQ(sheet.total.value(), total);
  EXPECT_EQ(
      FormatMessage(*MakeReview(sheet).nerve),
      "The nerve canal was injured, and 3.3 mm³ of it were removed. The planned plane crosses the canal, so this costs "
      "no points.");
  sheet.canal_severed = true;
  EXPECT_THAT(FormatMessage(*MakeReview(sheet).nerve), HasSubstr("The nerve canal was severed"));
  SetValue(sheet, "breach_mm3", 0.01);
  EXPECT_THAT(FormatMessage(*MakeReview(sheet).nerve), HasSubstr("touched the nerve canal"));
  for (const ExerciseKind kind : kReviewed) {
    ScoreSheet other = PerfectSheet(kind);
    EXPECT_FALSE(MakeReview(other).nerve) << "no canal is known";
    other.plan_nerve_mm = -1.4;
    EXPECT_EQ(MakeReview(other).nerve.has_value(), kind == ExerciseKind::kOsteotomy);
  }
}

// Only a plan that crosses the canal is said to cross it.
TEST(Review, OsteotomySaysHowFarItsPlanIsFromTheNerve) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  sheet.plan_nerve_mm = 5.5;
  const auto nerve = [&] { return FormatMessage(MakeReview(sheet).nerve.value()); };
  EXPECT_EQ(nerve(),
            "The blade came no nearer than 2.6 mm to the nerve canal. The planned cut passes 5.5 mm from the canal.");
  SetValue(sheet, "breach_mm3", 3.3);
  SetValue(sheet, "breaches", 1);
  EXPECT_EQ(nerve(),
            "The nerve canal was injured, and 3.3 mm³ of it were removed. The planned cut passes 5.5 mm from the "
            "canal.");
  sheet.canal_severed = true;
  EXPECT_THAT(nerve(), HasSubstr("The nerve canal was severed"));
  SetValue(sheet, "breach_mm3", 0.01);
  EXPECT_THAT(nerve(), HasSubstr("touched the nerve canal. The planned cut passes 5.5 mm"));
}

// A plan that sacrifices a nerve or a tooth is followed, but not praised.
TEST(Review, CutThatInjuresAsPlannedIsNotCalledExcellent) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  EXPECT_THAT(Headline(sheet), HasSubstr("An excellent cut"));
  StructureResult nerve;
  nerve.kind = MarkKind::kCanal;
  nerve.removed_mm3 = 3;
  sheet.crossed = {nerve};
  EXPECT_EQ(Headline(sheet),
            "The cut follows its plan, and injures what an operation spares where it can, as named below.");
}

// Whether the level is passed comes before what could be better, by the rule by which the next level is recommended.
TEST(Review, PassedLevelIsSaidFirst) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  sheet.level = 2;
  SetValue(sheet, "cut_share", 0.99);
  SetValue(sheet, "plane_angle_deg", 3);
  CalcTotal(sheet);
  ASSERT_GE(sheet.total.value(), kGoodTotal);
  ASSERT_TRUE(MakeReview(sheet).passed);
  EXPECT_THAT(FormatMessage(*MakeReview(sheet).passed), HasSubstr("Level 2 is passed with "));
  EXPECT_THAT(Headline(sheet), HasSubstr("Your cut"));
  SetValue(sheet, "cut_share", 0.97);  // the bone holds together
  CalcTotal(sheet);
  ASSERT_GE(sheet.total.value(), kGoodTotal);
  EXPECT_FALSE(MakeReview(sheet).passed);
  sheet.kind = ExerciseKind::kGroove;
  EXPECT_TRUE(MakeReview(sheet).passed);
  sheet.total = kGoodTotal - 0.1;
  EXPECT_FALSE(MakeReview(sheet).passed);
}

TEST(Review, LostPointsOfAllFiguresAddUpToTheRoundedTotal) {
  for (const ExerciseKind kind : kReviewed) {
    for (const double step : {0.02, 0.1, 0.3, 0.9}) {
      ScoreSheet sheet = PerfectSheet(kind);
      double value = 0;
      for (const Goal& goal : GoalsOf(kind)) SetValue(sheet, goal.key, value += step);
      SetValue(sheet, "cut_share", 1 - 0.2 * step);
      CalcTotal(sheet);
      const ExerciseReview review = MakeReview(sheet);
      int sum = 0;
      for (const auto* list : {&review.figures, &review.rest}) {
        for (const ReviewFigure& figure : *list) {
          sum += figure.lost_points;
          EXPECT_NEAR(figure.lost_points, figure.lost.value_or(0), 1) << figure.info->key;
          EXPECT_FALSE(figure.lost_points > 0 && figure.level == ReviewLevel::kGood) << figure.info->key;
          if (figure.lost_points > 0 && figure.relation == GoalRelation::kEqual && figure.value) {
            const Quantity goal{figure.goal->value, figure.value->digits, figure.goal->unit};
            EXPECT_NE(FormatQuantity(*figure.value), FormatQuantity(goal)) << figure.info->key;
          }
        }
      }
      EXPECT_EQ(sum, 100 - std::lround(sheet.total.value()));
    }
  }
}

TEST(Review, HandThatDoesNotTrembleIsNotPraisedForIt) {
  // The weight of the trembling is small here, so that it costs no points.
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  for (const char* key : {"plane_offset_mm", "plane_angle_deg", "outside_mm3", "path_length_mm", "time_total_s"}) {
    SetValue(sheet, key, 10);
  }
  SetValue(sheet, "jitter_mm", 0.006);
  CalcTotal(sheet);
  EXPECT_THAT(FormatMessage(MakeReview(sheet).praise.value()), HasSubstr("trembled by only 0.01 mm"));
  SetValue(sheet, "jitter_mm", 0.001);
  CalcTotal(sheet);
  EXPECT_THAT(FormatMessage(MakeReview(sheet).praise.value()), testing::Not(HasSubstr("trembled")));
  SetValue(sheet, "jitter_mm", 0.05);
  CalcTotal(sheet);
  EXPECT_THAT(FormatMessage(MakeReview(sheet).praise.value()), testing::Not(HasSubstr("trembled")));
}

TEST(Review, FiguresAreThoseOfTheExercise) {
  for (const ExerciseKind kind : kReviewed) {
    const ExerciseReview review = MakeReview(PerfectSheet(kind));
    EXPECT_EQ(review.figures.size(), kReviewFigures);
    std::set<std::string> keys;
    for (const auto* list : {&review.figures, &review.rest}) {
      for (const ReviewFigure& figure : *list) {
        EXPECT_TRUE(keys.insert(figure.info->key).second) << figure.info->key;
        EXPECT_TRUE(IsMeaningful(*figure.info, kind)) << figure.info->key;
      }
    }
    for (const ReviewFigure& figure : review.figures) {
      EXPECT_TRUE(figure.goal) << figure.info->key;
      EXPECT_NE(figure.level, ReviewLevel::kPlain) << figure.info->key;
    }
    // All scored measures are shown.
    for (const Goal& goal : GoalsOf(kind)) EXPECT_TRUE(keys.contains(goal.key)) << goal.key;
    EXPECT_EQ(keys.contains("plunge_max_mm"), kind == ExerciseKind::kBicortical || kind == ExerciseKind::kOsteotomy ||
                                                  kind == ExerciseKind::kStopBeforeFar);
    EXPECT_EQ(keys.contains("nerve_distance_mm"),
              kind == ExerciseKind::kBesideCanal || kind == ExerciseKind::kOsteotomy);
  }
}

// A disc that stays in its plane and goes through the bone: nothing lies beside the line.
TEST(Review, BoneRemovedBelowTheCutCountsForTheDepth) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kFollowLine);
  SetValue(sheet, "too_deep_mm", 12);
  SetValue(sheet, "outside_mm3", 96);
  SetValue(sheet, "removed_mm3", 110);
  sheet.below_mm3 = 90;
  sheet.beyond_mm3 = 6;
  EXPECT_EQ(Headline(sheet), "You cut 12.0 mm too deep. Slow down before you reach the depth of 2.0 mm.");
  CalcTotal(sheet);
  double sum = 0;
  for (const FaultLoss& loss : FindLosses(sheet)) {
    EXPECT_NE(loss.fault, Fault::kOutside);
    sum += loss.lost;
  }
  EXPECT_NEAR(sum, 100 - sheet.total.value(), 1e-9);
  // What lies below is not beside either, wherever the mean of the removed bone lies.
  sheet.beside_mm = 1;
  sheet.incomplete = {"the exercise is not finished"};
  SetValue(sheet, "line_share", 0.4);
  EXPECT_THAT(Headline(sheet), testing::Not(HasSubstr("beside")));
  CalcTotal(sheet);
  ASSERT_FALSE(MakeReview(sheet).notes.empty());
  EXPECT_THAT(FormatMessage(MakeReview(sheet).notes[0]), HasSubstr("12.0 mm too deep"));
  ScoreSheet beyond = PerfectSheet(ExerciseKind::kFollowLine);
  SetValue(beyond, "outside_mm3", 20);
  beyond.beyond_mm3 = 20;
  EXPECT_THAT(Headline(beyond), HasSubstr("20 mm³ beyond the ends of the line"));
}

TEST(Review, UngradedCutAlongTheWholeLineIsTooShallowOrTooFast) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kFollowLine);
  sheet.incomplete = {"the exercise is not finished"};
  sheet.exercise.feed_mm_per_s = 3;
  SetValue(sheet, "line_share", 0.63);
  sheet.begun_share = 1;
  sheet.depth_mm = 0.7;
  SetValue(sheet, "feed_mean_mm_per_s", 2.8);
  EXPECT_EQ(
      Headline(sheet),
      "Your cut is too shallow to be scored: it is 0.7 mm deep on average, and 2.0 mm are wanted. Go to the depth "
      "first, and keep pressing down while you move along the line.");
  SetValue(sheet, "feed_mean_mm_per_s", 9.2);
  EXPECT_THAT(Headline(sheet), HasSubstr("You were too fast, at 9.2 mm/s; 3.0 mm/s are wanted."));
  // The sides of a blade with a stroke have no teeth.
  sheet.strokes = true;
  EXPECT_THAT(Headline(sheet), testing::AllOf(HasSubstr("0.7 mm deep on average"), HasSubstr("straight down"),
                                              testing::Not(HasSubstr("along the line"))));
  sheet.begun_share = 0.7;
  EXPECT_THAT(Headline(sheet), HasSubstr("Cut along the whole line"));
}

// The mean beside the wanted feed, and the reason.
TEST(Review, FeedThatIsTooSlowHasAReason) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kFollowLine);
  sheet.exercise.feed_mm_per_s = 3;
  SetValue(sheet, "feed_error", 0.7);
  const auto say = [&](const FeedAlong& along) {
    sheet.feed_along = along;
    return Headline(sheet);
  };
  const FeedAlong slow{.slowest_mm_per_s = 0, .fastest_mm_per_s = 2.4, .mean_mm_per_s = 1.6, .slow_share = 0.9};
  FeedAlong pressed = slow;
  pressed.slow_force_N = 8.2;
  FeedAlong rested = pressed;
  rested.rest_share = 0.3;
  FeedAlong fast{.slowest_mm_per_s = 3, .fastest_mm_per_s = 9, .mean_mm_per_s = 7, .fast_share = 0.9};
  EXPECT_EQ(
      say(slow),
      "Your feed was too slow: 1.6 mm/s on average, and 3.0 mm/s are wanted. Move the saw faster: press the ] key.");
  EXPECT_EQ(say(pressed),
            "Your feed was too slow: 1.6 mm/s on average, and 3.0 mm/s are wanted. You pressed with 8 N: press less.");
  EXPECT_EQ(say(rested),
            "Your feed was too slow: 1.6 mm/s on average, and 3.0 mm/s are wanted. The saw rested for 30 % of the time "
            "along the line: keep moving it.");
  // Too fast on much of the line, which takes little time, and too slow elsewhere: its mean says nothing.
  FeedAlong uneven = rested;
  uneven.fastest_mm_per_s = 9;
  uneven.slow_share = 0.7;
  uneven.fast_share = 0.2;
  EXPECT_EQ(say(uneven),
            "Your feed was uneven: at most 9.0 mm/s and at least 0.0 mm/s along the line, and a constant 3.0 mm/s is "
            "wanted. Hold the key along the line without pauses; the [ and ] keys change its speed.");
  EXPECT_EQ(say(fast),
            "Your feed was too fast: 7.0 mm/s on average, and 3.0 mm/s are wanted. Move the saw more slowly: press the "
            "[ key.");
}

TEST(Review, CutRightThroughTheBoneSaysSo) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  SetValue(sheet, "too_deep_mm", 11.5);
  sheet.through_mm = 13.5;
  EXPECT_EQ(
      Headline(sheet),
      "You cut right through the bone, which is 13.5 mm thick here: 11.5 mm too deep. Slow down before you reach the "
      "depth of 2.0 mm.");
  // It is said once, also if something else cost more.
  CalcTotal(sheet);
  EXPECT_TRUE(MakeReview(sheet).notes.empty());
  SetValue(sheet, "cut_share", 0.2);
  CalcTotal(sheet);
  ASSERT_EQ(MakeReview(sheet).notes.size(), 1u);
  EXPECT_THAT(FormatMessage(MakeReview(sheet).notes[0]), HasSubstr("right through the bone"));
}

TEST(Review, ExactPlaceIsNotOnlySomeMillimetresAway) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kOsteotomy);
  SetValue(sheet, "cut_share", 0.8);
  CalcTotal(sheet);
  EXPECT_EQ(FormatMessage(MakeReview(sheet).praise.value()),
            "The place of your cut is exact: it lies in the wanted plane.");
}

TEST(Review, ScratchHasNoAngle) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  SetValue(sheet, "plane_angle_deg", 9.3);
  EXPECT_TRUE(IsPlaneSensible(sheet));
  sheet.incomplete = {"the exercise is not finished"};
  CalcTotal(sheet);
  sheet.depth_mm = 0.7;
  EXPECT_FALSE(IsPlaneSensible(sheet));
  sheet.depth_mm = 1.8;
  EXPECT_TRUE(IsPlaneSensible(sheet));
}

TEST(Review, PraiseIsNeitherTheHeadlineNorWhatCostPoints) {
  for (const ExerciseKind kind : kReviewed) {
    for (const Goal& goal : GoalsOf(kind)) {
      for (const double value : {0.03, 0.2, 1.0}) {
        ScoreSheet sheet = PerfectSheet(kind);
        SetValue(sheet, goal.key, value);
        CalcTotal(sheet);
        const ExerciseReview review = MakeReview(sheet);
        for (const auto* list : {&review.figures, &review.rest}) {
          for (const ReviewFigure& figure : *list) {
            if (figure.lost_points == 0 || !review.praise) continue;
            EXPECT_STREQ(figure.info->key, goal.key);
            // The same measure, perfect, would have been praised in these words.
            EXPECT_THAT(FormatMessage(*review.praise), testing::Not(HasSubstr(FormatQuantity(*figure.value))));
          }
        }
      }
    }
  }
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  SetValue(sheet, "too_deep_mm", 0.2);
  EXPECT_THAT(Headline(sheet), HasSubstr("0.2 mm too deep"));
  CalcTotal(sheet);
  EXPECT_THAT(FormatMessage(MakeReview(sheet).praise.value()), testing::Not(HasSubstr("depth")));
}

// A disc is half as deep as wanted ahead of its lowest point, so that line_share alone does not tell.
TEST(Review, WholeLineIsPraisedOnlyIfTheCutIsMade) {
  const auto praise = [](double cut_share) {
    ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
    for (const MeasureRow& row : std::vector(sheet.rows)) {
      if (row.weight > 0) SetValue(sheet, row.info->key, row.goal + row.half);  // everything costs points
    }
    SetValue(sheet, "cut_share", cut_share);
    CalcTotal(sheet);
    const ExerciseReview review = MakeReview(sheet);
    return review.praise ? FormatMessage(*review.praise) : "";
  };
  EXPECT_EQ(praise(1), "You have followed the whole line.");
  EXPECT_EQ(praise(0.9), "");
}

TEST(Review, MarksFollowThePointsThatAreShown) {
  for (const ExerciseKind kind : kReviewed) {
    for (const double step : {0.003, 0.02, 0.1, 0.3, 0.9, 2.0}) {
      ScoreSheet sheet = PerfectSheet(kind);
      double value = 0;
      for (const Goal& goal : GoalsOf(kind)) SetValue(sheet, goal.key, value += step);
      SetValue(sheet, "cut_share", 1 - 0.3 * step);
      CalcTotal(sheet);
      const ExerciseReview review = MakeReview(sheet);
      for (const auto* list : {&review.figures, &review.rest}) {
        for (const ReviewFigure& figure : *list) {
          if (!figure.scored) {
            EXPECT_EQ(figure.lost_points, 0) << figure.info->key;
            continue;
          }
          EXPECT_EQ(figure.level == ReviewLevel::kGood, figure.lost_points == 0) << figure.info->key;
          EXPECT_NE(figure.level, ReviewLevel::kPlain) << figure.info->key;
          // A goal that is met costs nothing.
          if (figure.relation == GoalRelation::kAtMost && figure.value->value <= figure.goal->value) {
            EXPECT_EQ(figure.lost_points, 0) << figure.info->key;
          }
        }
      }
    }
  }
}

TEST(Review, SaysThatTheTimeWasUpAndNotToSwitchOnWhatWasOn) {
  ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);
  sheet.incomplete = {"the exercise is not finished"};
  sheet.exercise.time_limit_s = 120;
  SetValue(sheet, "removed_mm3", 0);
  SetValue(sheet, "time_total_s", 119);
  EXPECT_THAT(Headline(sheet), HasSubstr("Switch the spindle on"));
  EXPECT_TRUE(MakeReview(sheet).notes.empty());
  sheet.turned = true;
  SetValue(sheet, "time_total_s", 120.02);
  EXPECT_EQ(Headline(sheet), "Nothing was cut. Lower the turning blade into the bone on the line.");
  ASSERT_EQ(MakeReview(sheet).notes.size(), 1U);
  EXPECT_EQ(FormatMessage(MakeReview(sheet).notes[0]), "The time was up: the attempt ended after 120 s.");
}

TEST(Review, LabelsAreShortAndUnique) {
  std::set<std::string> labels;
  for (const MeasureInfo& info : Measures()) {
    const std::string label = LabelOf(info);
    EXPECT_LE(Length(label), kMaxLabelLength) << label;
    EXPECT_TRUE(labels.insert(label).second) << label;
    EXPECT_NE(label, info.name) << "no short label: " << info.key;
  }
}

// A student who has never heard of a spectrum can read what each figure says.
TEST(Review, EveryMeasureHasAPlainMeaning) {
  std::set<std::string> meanings;
  for (const MeasureInfo& info : Measures()) {
    const std::string meaning = MeaningOf(info);
    EXPECT_NE(meaning, info.formula) << "no meaning: " << info.key;
    EXPECT_TRUE(meanings.insert(meaning).second) << meaning;
    EXPECT_TRUE(meaning.ends_with('.')) << meaning;
    for (const char* term : {"spectrum", "deviation", "percentile", "median", "normal", "amplitude", "RMS", "|", "_"}) {
      EXPECT_EQ(meaning.find(term), std::string::npos) << info.key << " uses \"" << term << '"';
    }
  }
  const std::string page = FormatSheetHtml(PerfectSheet(ExerciseKind::kGroove));
  for (const char* key : {"sparc", "feed_cv", "dice", "too_deep_mm"}) {
    EXPECT_NE(page.find(MeaningOf(FindMeasure(key))), std::string::npos) << key;
  }
}

// A planned cut through the canal has a sentence about it; a negative distance beside it would only puzzle.
TEST(Review, NegativeDistanceToTheNerveIsShownOnlyWhereTheNerveIsSpared) {
  const auto shows = [](ExerciseKind kind, double distance_mm) {
    ScoreSheet sheet = PerfectSheet(kind);
    SetValue(sheet, "nerve_distance_mm", distance_mm);
    const ExerciseReview review = MakeReview(sheet);
    bool found = false;
    for (const auto* list : {&review.figures, &review.rest}) {
      for (const ReviewFigure& figure : *list) found = found || figure.info == &FindMeasure("nerve_distance_mm");
    }
    return found;
  };
  EXPECT_TRUE(shows(ExerciseKind::kBesideCanal, -1.2));
  EXPECT_FALSE(shows(ExerciseKind::kOsteotomy, -1.2));
  EXPECT_TRUE(shows(ExerciseKind::kOsteotomy, 1.2));
}

TEST(Review, LevelsFollowThePoints) {
  for (const auto& [value, level] : {std::pair{0.05, ReviewLevel::kGood},
                                     {0.9, ReviewLevel::kWarn},
                                     {2.0, ReviewLevel::kWarn},
                                     {3.5, ReviewLevel::kBad}}) {
    ScoreSheet sheet = PerfectSheet(ExerciseKind::kGroove);  // half of the points at 2 mm
    SetValue(sheet, "plane_offset_mm", value);
    CalcTotal(sheet);
    EXPECT_EQ(MakeReview(sheet).figures.front().level, level) << value;
  }
}

TEST(Review, GoalsAreShortNumbers) {
  const ExerciseReview review = MakeReview(PerfectSheet(ExerciseKind::kBesideCanal));
  EXPECT_EQ(FormatGoal(review.figures[0]), "≥ 2 mm");
  EXPECT_EQ(FormatGoal(review.figures[1]), "0 mm³");
  EXPECT_EQ(FormatGoal(MakeReview(PerfectSheet(ExerciseKind::kGroove)).figures[4]), "≤ 5 s");
}

TEST(Quantity, HasTypographicUnitsAndTheLocalesPoint) {
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("outside_mm3"), 2.26)), "2.3 mm³");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("plane_angle_deg"), 5.24)), "5.2°");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("cut_share"), 0.834)), "83 %");
  // What is not perfect does not read so.
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("cut_share"), 0.998)), "99 %");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("cut_share"), 1)), "100 %");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("under_mm3"), 0.03)), "0.03 mm³");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("under_mm3"), 0.002)), "0.01 mm³");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("under_mm3"), 0)), "0.0 mm³");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("plane_offset_mm"), -0.04)), "-0.04 mm");
  EXPECT_EQ(FormatQuantity(ShowMeasure(FindMeasure("dice"), 0.9985)), "0.99");
  EXPECT_EQ(FormatQuantity({-0.04, 1, "mm"}), "0.0 mm");
  EXPECT_EQ(FormatQuantity({3.14, 1, "mm"}, ","), "3,1 mm");
}

}  // namespace
}  // namespace kerf
