// Tests of the trend and of the recommended next step.
#include "session/practise/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>
#include <vector>

#include "kerf/error.h"

namespace kerf {
namespace {

using Kind = NextStep::Kind;

Attempt MakeTry(const std::string& exercise, int level, std::optional<double> total) {
  Attempt a;
  a.student = "Ann";
  a.exercise = exercise;
  a.level = level;
  a.total = total;
  if (!total) a.incomplete = "the exercise is not finished";
  return a;
}

std::vector<Attempt> MakeTries(const std::string& exercise, int level,
                               const std::vector<std::optional<double>>& totals) {
  std::vector<Attempt> attempts;
  for (const auto& total : totals) attempts.push_back(MakeTry(exercise, level, total));
  return attempts;
}

TEST(FindTrend, IsTheSignOfTheSlopeIfItMatters) {
  EXPECT_EQ(FindTrend({}), Trend::kUnknown);
  EXPECT_EQ(FindTrend(std::vector<double>{10, 90}), Trend::kUnknown);
  EXPECT_EQ(FindTrend(std::vector<double>{40, 50, 60}), Trend::kRising);
  EXPECT_EQ(FindTrend(std::vector<double>{60, 50, 40}), Trend::kFalling);
  EXPECT_EQ(FindTrend(std::vector<double>{60, 60, 60}), Trend::kSteady);
  // The regression line of equally spaced totals changes by exactly their difference.
  EXPECT_EQ(FindTrend(std::vector<double>{50, 52.4, 54.8}), Trend::kSteady);
  EXPECT_EQ(FindTrend(std::vector<double>{50, 52.6, 55.2}), Trend::kRising);
  // One outlier in the middle does not change the slope.
  EXPECT_EQ(FindTrend(std::vector<double>{50, 90, 50}), Trend::kSteady);
}

TEST(FindTrend, ConsidersOnlyTheLastAttempts) {
  std::vector<double> totals(10, 90);
  for (std::size_t i = 0; i < kMaxTrendAttempts; ++i) totals.push_back(20);
  EXPECT_EQ(FindTrend(totals), Trend::kSteady);
}

TEST(FindTrend, OfTheReversedAttemptsIsTheOpposite) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(0, 100);
  for (int i = 0; i < 200; ++i) {
    std::vector<double> totals(3 + random() % 4);
    for (double& total : totals) total = any(random);
    const Trend trend = FindTrend(totals);
    std::reverse(totals.begin(), totals.end());
    const Trend opposite = trend == Trend::kRising    ? Trend::kFalling
                           : trend == Trend::kFalling ? Trend::kRising
                                                      : trend;
    EXPECT_EQ(FindTrend(totals), opposite);
  }
}

/// Recommends the step after the last attempt of `history`.
NextStep RecommendAfter(const std::vector<Attempt>& history) {
  const Attempt& last = history.back();
  return Recommend(history, last.exercise, last.level, last.total);
}

TEST(Recommend, LowScoreIsFollowedByTheSameLevel) {
  for (const double total : {0.0, 12.0, 45.0, 69.9}) {
    const NextStep step = RecommendAfter(MakeTries("groove", 2, {total}));
    EXPECT_EQ(step.kind, Kind::kRepeat) << total;
    EXPECT_EQ(step.level, 2);
    EXPECT_EQ(step.exercise, "groove");
  }
  EXPECT_EQ(RecommendAfter(MakeTries("groove", 1, {std::nullopt})).kind, Kind::kRepeat);
}

TEST(Recommend, BestScoresOfAllAttemptsCount) {
  std::vector<Attempt> history = MakeTries("groove", 1, {93});
  history.push_back(MakeTry("groove", 2, 88));
  // Repeating a level that is passed, with a good score, does not lead back.
  std::vector<Attempt> more = history;
  more.push_back(MakeTry("groove", 1, 97));
  const NextStep good = RecommendAfter(more);
  EXPECT_EQ(good.kind, Kind::kNextLevel);
  EXPECT_EQ(good.level, 3);
  EXPECT_EQ(FindNextStep(more), good);
  // After another exercise, that one goes on.
  history.push_back(MakeTry("mandibulotomy", 1, 96));
  EXPECT_EQ(RecommendAfter(history).kind, Kind::kNextLevel);
  EXPECT_EQ(RecommendAfter(history).exercise, "mandibulotomy");
  EXPECT_EQ(RecommendAfter(history).level, 2);
  // When all of its levels are passed, what was left out comes first.
  history.push_back(MakeTry("mandibulotomy", 5, 96));
  const NextStep step = RecommendAfter(history);
  EXPECT_EQ(step.kind, Kind::kNextExercise);
  EXPECT_EQ(step.exercise, "groove");
  EXPECT_EQ(step.level, 3);
  EXPECT_EQ(FormatMessage(step.reason),
            "Level 5 is passed with 96 of 100 points: go on with the exercise \"Groove of 2 mm\", level 3.");
}

// What was done before, here or at other levels, is not what the step after this attempt speaks of.
TEST(Recommend, SpeaksOfTheAttemptJustMade) {
  std::vector<Attempt> history = MakeTries("groove", 1, {95});
  for (const Attempt& a : MakeTries("groove", 2, {20, 12})) history.push_back(a);
  struct Case {
    std::optional<double> total;
    Kind kind;
    int level;
    const char* reason;
  };
  const Case cases[] = {
      {std::nullopt, Kind::kRepeat, 1, "Your last attempt at level 1 was not graded: try it again."},
      {42.0, Kind::kRepeat, 1, "42 of 100 points: try level 1 again; 70 points are enough."},
      {72.0, Kind::kNextLevel, 2,
       "Level 1 is passed with 72 of 100 points: go on with level 2, which has 2 fewer aids."},
  };
  for (const Case& c : cases) {
    std::vector<Attempt> more = history;
    more.push_back(MakeTry("groove", 1, c.total));
    const NextStep step = RecommendAfter(more);
    EXPECT_EQ(step.kind, c.kind);
    EXPECT_EQ(step.exercise, "groove");
    EXPECT_EQ(step.level, c.level);
    EXPECT_EQ(FormatMessage(step.reason), c.reason);
  }
  // An attempt in which nothing was cut is not in the history.
  const NextStep nothing = Recommend({}, "groove", 4, {});
  EXPECT_EQ(nothing.kind, Kind::kRepeat);
  EXPECT_EQ(nothing.level, 4);
  EXPECT_EQ(FormatMessage(nothing.reason), "Your last attempt at level 4 was not graded: try it again.");
}

TEST(Recommend, NamesTheTrueNumberOfAids) {
  // Level 2 has neither the steps nor the depth stop of level 1.
  EXPECT_EQ(FormatMessage(RecommendAfter(MakeTries("groove", 1, {90})).reason),
            "Level 1 is passed with 90 of 100 points: go on with level 2, which has 2 fewer aids.");
  EXPECT_EQ(FormatMessage(RecommendAfter(MakeTries("groove", 2, {90})).reason),
            "Level 2 is passed with 90 of 100 points: go on with level 3, which has one aid fewer.");
}

TEST(Recommend, GoodScoreIsFollowedByTheNextLevelThenTheNextExercise) {
  EXPECT_EQ(RecommendAfter(MakeTries("groove", 1, {10, 70})).level, 2);
  EXPECT_EQ(RecommendAfter(MakeTries("groove", 1, {10, 70})).kind, Kind::kNextLevel);
  const NextStep next = RecommendAfter(MakeTries("groove", 5, {88}));
  EXPECT_EQ(next.kind, Kind::kNextExercise);
  EXPECT_EQ(next.exercise, ListExercises()[1].id);
  EXPECT_EQ(next.level, 1);
  std::vector<Attempt> all;
  for (const Exercise& e : ListExercises()) all.push_back(MakeTry(e.id, 5, 88));
  EXPECT_EQ(RecommendAfter(all).kind, Kind::kFinished);
}

TEST(Recommend, TwoPoorScoresLeadBackOneLevel) {
  EXPECT_EQ(RecommendAfter(MakeTries("groove", 3, {5})).kind, Kind::kRepeat);
  const NextStep back = RecommendAfter(MakeTries("groove", 3, {5, 20}));
  EXPECT_EQ(back.kind, Kind::kPreviousLevel);
  EXPECT_EQ(back.level, 2);
  EXPECT_EQ(RecommendAfter(MakeTries("groove", 1, {5, 20})).kind, Kind::kRepeat);
}

TEST(Recommend, CountsOnlyAttemptsAtThatLevelAndNoDamagedRows) {
  std::vector<Attempt> history = MakeTries("groove", 3, {5});
  for (const Attempt& a : MakeTries("groove", 2, {3})) history.push_back(a);
  EXPECT_EQ(RecommendAfter(history).kind, Kind::kRepeat);
  history.push_back(MakeTry("groove", 2, 3));
  EXPECT_EQ(RecommendAfter(history).kind, Kind::kPreviousLevel);
  history[1].damaged = true;
  EXPECT_EQ(RecommendAfter(history).kind, Kind::kRepeat);
  EXPECT_THROW(Recommend(history, "dancing", 1, 50), Error);
  EXPECT_THROW(Recommend(history, "groove", 0, 50), Error);
  EXPECT_THROW(Recommend(history, "groove", kLevels + 1, 50), Error);
}

TEST(ListProgress, ShowsBestScoresTrendAndNextStep) {
  std::vector<Attempt> history = MakeTries("groove", 1, {20, 90, std::nullopt, 40});
  for (const Attempt& a : MakeTries("groove", 2, {30, 50, 65})) history.push_back(a);
  history.push_back(MakeTry("some scene", 1, 100));  // not one of the exercises
  history.push_back(MakeTry("plate_holes", 3, 60));
  const std::vector<ExerciseRow> rows = ListProgress(history);
  ASSERT_EQ(rows.size(), ListExercises().size() + ListProcedures().size());
  EXPECT_EQ(rows[0].id, "groove");
  EXPECT_EQ(rows[0].attempts, 6U);
  EXPECT_EQ(rows[0].unfinished, 1U);
  EXPECT_EQ(rows[0].best[0], 90);
  EXPECT_EQ(rows[0].best[1], 65);
  EXPECT_FALSE(rows[0].best[2]);
  EXPECT_EQ(rows[0].last, 65);
  EXPECT_EQ(rows[0].level, 2);
  EXPECT_EQ(rows[0].trend, Trend::kRising);
  EXPECT_EQ(rows[0].next, Recommend(history, "groove", 2, 65));
  EXPECT_EQ(rows[1].attempts, 0U);
  EXPECT_EQ(rows[1].trend, Trend::kUnknown);
  EXPECT_EQ(rows[0].totals, (std::vector<double>{30, 50, 65}));
  const auto holes = std::find_if(rows.begin(), rows.end(), [](const auto& row) { return row.id == "plate_holes"; });
  ASSERT_NE(holes, rows.end());
  EXPECT_EQ(holes->best[2], 60);
  EXPECT_EQ(FindNextStep(history), rows[0].next);
}

NextStep NextAfter(const std::vector<Attempt>& history) {
  return FindNextStep(history);
}

TEST(ListProgress, NextStepIsTheFirstLevelThatIsNotPassed) {
  EXPECT_EQ(NextAfter({}).exercise, "groove");
  EXPECT_EQ(NextAfter({}).level, 1);
  std::vector<Attempt> history = MakeTries("groove", 2, {80});
  history.push_back(MakeTry("mandibulotomy", 1, 93));
  EXPECT_EQ(NextAfter(history).exercise, "groove");
  EXPECT_EQ(NextAfter(history).level, 3);
  history.push_back(MakeTry("groove", 3, std::nullopt));
  EXPECT_EQ(NextAfter(history).kind, Kind::kRepeat);
  // Damaged rows and attempts at other scenes are left out.
  history.push_back(MakeTry("groove", 5, 90));
  history.back().damaged = true;
  history.push_back(MakeTry("some scene", 5, 100));
  EXPECT_EQ(NextAfter(history).level, 3);
}

TEST(ListProgress, NextStepFollowsTheOrderOfDifficulty) {
  const std::vector<Attempt> done = MakeTries("groove", 5, {80});
  EXPECT_EQ(NextAfter(done).exercise, ListExercises()[1].id);
  // After the last exercise, what was left out comes next.
  const std::vector<Attempt> last = MakeTries(ListExercises().back().id, 5, {80});
  EXPECT_EQ(NextAfter(last).exercise, "groove");
  std::vector<Attempt> all;
  for (const Exercise& e : ListExercises()) all.push_back(MakeTry(e.id, 5, 99));
  EXPECT_EQ(NextAfter(all).kind, Kind::kFinished);
}

// A bone that still holds together is not cut through, however good the rest is.
TEST(Recommend, OsteotomyThatIsNotThroughIsNotPassed) {
  const auto after = [](const char* cut_share) {
    std::vector<Attempt> history = MakeTries("mandibulotomy", 1, {79});
    history.back().measures_json = std::string(R"({"measures": {"cut_share": {"value": )") + cut_share + "}}}";
    EXPECT_TRUE(history.back().Get("cut_share"));
    return Recommend(history, "mandibulotomy", 1, 79);
  };
  EXPECT_EQ(after("0.85").kind, Kind::kRepeat);
  EXPECT_EQ(FormatMessage(after("0.85").reason), "The bone is not cut through: try level 1 again.");
  EXPECT_EQ(after("0.99").kind, Kind::kNextLevel);
}

TEST(ListAids, EachLevelHasOneLess) {
  int last = 1 << 20;
  for (int level = 1; level <= kLevels; ++level) {
    const std::vector<Aid> aids = ListAids(MakeExerciseScene("groove", level).exercise, false, false);
    int on = 0;
    for (const Aid& aid : aids) on += aid.on ? 1 : 0;
    EXPECT_LT(on, last);
    last = on;
  }
  EXPECT_EQ(last, 0);
}

}  // namespace
}  // namespace kerf
