#include "session/practise/progress.h"

#include <algorithm>
#include <utility>

#include "session/score/measures.h"

namespace kerf {
namespace {

Quantity Points(double total) {
  return {total, 0, ""};
}

/// Best totals of the levels of an exercise.
using BestTotals = std::array<std::optional<double>, kLevels>;

bool IsNotThrough(const Attempt& attempt, const Exercise& exercise) {
  return IsNotThrough(exercise.kind, attempt.Get("cut_share").value_or(1));
}

/// Returns the best totals of the attempts that can pass their levels.
BestTotals FindBest(std::span<const Attempt> history, const Exercise& exercise) {
  BestTotals best;
  for (const Attempt& a : history) {
    if (!a.graded() || a.exercise != exercise.id || a.level < 1 || a.level > kLevels) continue;
    if (IsNotThrough(a, exercise)) continue;
    std::optional<double>& total = best[static_cast<std::size_t>(a.level - 1)];
    total = std::max(total.value_or(0), *a.total);
  }
  return best;
}

/// Returns the highest level that was passed; 0: none. It passes those below it too.
int FindPassed(const BestTotals& best) {
  for (int level = kLevels; level >= 1; --level) {
    if (best[static_cast<std::size_t>(level - 1)].value_or(0) >= kGoodTotal) return level;
  }
  return 0;
}

/// Returns the number of aids of a level.
int CountAids(const Exercise& exercise, int level) {
  const std::vector<Aid> aids = ListAids(MakeExerciseScene(exercise, level).exercise, false, false);
  return static_cast<int>(std::count_if(aids.begin(), aids.end(), [](const Aid& aid) { return aid.on; }));
}

/// Recommends a level of an exercise, after the one below it was passed with `total`.
NextStep GoOn(const Exercise& exercise, int level, double total) {
  const int fewer = CountAids(exercise, level - 1) - CountAids(exercise, level);
  NextStep next{NextStep::Kind::kNextLevel, exercise.id, level, {}};
  next.reason = {fewer == 1 ? MarkMessage("Level {0} is passed with {1} of 100 points: go on with level {2}, which has "
                                          "one aid fewer.")
                            : MarkMessage("Level {0} is passed with {1} of 100 points: go on with level {2}, which has "
                                          "{3} fewer aids."),
                 {Points(level - 1), Points(total), Points(level)}};
  if (fewer != 1) next.reason.values.emplace_back(Points(fewer));
  return next;
}

/// Recommends the step after an attempt that has no score.
NextStep RepeatUngraded(const Exercise& exercise, int level) {
  return {NextStep::Kind::kRepeat,
          exercise.id,
          level,
          {MarkMessage("Your last attempt at level {0} was not graded: try it again."), {Points(level)}}};
}

/// Recommends the step after the last attempt at a level that is not passed, or in which a passed one failed.
NextStep RepeatLevel(std::span<const Attempt> history, const Exercise& exercise, int level) {
  std::vector<const Attempt*> attempts;
  for (const Attempt& a : history) {
    if (!a.damaged && a.exercise == exercise.id && a.level == level) attempts.push_back(&a);
  }
  const NextStep::Kind again = NextStep::Kind::kRepeat;
  if (attempts.empty()) {
    return {NextStep::Kind::kFirst,
            exercise.id,
            level,
            {MarkMessage("You have not tried level {0} yet."), {Points(level)}}};
  }
  const Attempt& last = *attempts.back();
  if (!last.graded()) return RepeatUngraded(exercise, level);
  const bool twice_poor = attempts.size() >= 2 && *last.total < kPoorTotal && attempts[attempts.size() - 2]->graded() &&
                          *attempts[attempts.size() - 2]->total < kPoorTotal;
  if (twice_poor && level > 1) {
    return {NextStep::Kind::kPreviousLevel,
            exercise.id,
            level - 1,
            {MarkMessage("Two attempts below {0} of 100 points: practise level {1} again, which has more aids."),
             {Points(kPoorTotal), Points(level - 1)}}};
  }
  if (IsNotThrough(last, exercise)) {
    return {
        again, exercise.id, level, {MarkMessage("The bone is not cut through: try level {0} again."), {Points(level)}}};
  }
  return {again,
          exercise.id,
          level,
          {MarkMessage("{0} of 100 points: try level {1} again; {2} points are enough."),
           {Points(*last.total), Points(level), Points(kGoodTotal)}}};
}

/// Recommends a level of one exercise: the first that is not passed, or none if all are.
std::optional<NextStep> RecommendIn(std::span<const Attempt> history, const Exercise& exercise) {
  const BestTotals best = FindBest(history, exercise);
  const int passed = FindPassed(best);
  if (passed == kLevels) return {};
  const NextStep next = RepeatLevel(history, exercise, passed + 1);
  if (passed == 0 || next.kind != NextStep::Kind::kFirst) return next;
  return GoOn(exercise, passed + 1, *best[static_cast<std::size_t>(passed - 1)]);
}

/// Recommends the first level of all exercises that is not passed.
NextStep RecommendFirst(std::span<const Attempt> history) {
  for (const Exercise& exercise : ListExercises()) {
    if (std::optional<NextStep> next = RecommendIn(history, exercise)) return *next;
  }
  return {NextStep::Kind::kFinished,
          ListExercises().back().id,
          kLevels,
          {MarkMessage("All exercises are passed without aids: you have done them all."), {}}};
}

}  // namespace

Trend FindTrend(std::span<const double> totals) {
  if (totals.size() < kMinTrendAttempts) return Trend::kUnknown;
  if (totals.size() > kMaxTrendAttempts) totals = totals.subspan(totals.size() - kMaxTrendAttempts);
  const auto n = static_cast<double>(totals.size());
  const double middle = 0.5 * (n - 1);
  double xy = 0;
  double xx = 0;
  for (std::size_t i = 0; i < totals.size(); ++i) {
    const double x = static_cast<double>(i) - middle;
    xy += x * totals[i];
    xx += x * x;
  }
  const double change = xy / xx * (n - 1);
  return change >= kTrendPoints ? Trend::kRising : change <= -kTrendPoints ? Trend::kFalling : Trend::kSteady;
}

NextStep Recommend(std::span<const Attempt> history, std::string_view exercise, int level,
                   std::optional<double> total) {
  return Recommend(history, FindExercise(exercise), level, total);
}

NextStep Recommend(std::span<const Attempt> history, const Exercise& exercise, int level, std::optional<double> total) {
  CheckRange("level", level, FindRange<SceneExercise>("level"));
  // An attempt in which nothing was cut is not in the history.
  if (!total) return RepeatUngraded(exercise, level);
  const bool is_last = !history.empty() && history.back().exercise == exercise.id && history.back().level == level;
  if (*total < kGoodTotal || (is_last && IsNotThrough(history.back(), exercise)))
    return RepeatLevel(history, exercise, level);
  const BestTotals best = FindBest(history, exercise);
  const int passed = std::max(FindPassed(best), level);
  if (passed < kLevels) {
    // Attempts at the next level came before this one, so that they are not spoken of.
    return GoOn(exercise, passed + 1, passed == level ? *total : *best[static_cast<std::size_t>(passed - 1)]);
  }
  NextStep next = RecommendFirst(history);
  if (next.kind == NextStep::Kind::kFinished) return next;
  return {NextStep::Kind::kNextExercise,
          next.exercise,
          next.level,
          {MarkMessage("Level {0} is passed with {1} of 100 points: go on with the exercise \"{2}\", level {3}."),
           {Points(level), Points(*total), FindExercise(next.exercise).title, Points(next.level)}}};
}

ExerciseRow MakeProgress(std::span<const Attempt> history, const Exercise& exercise) {
  ExerciseRow row;
  row.id = exercise.id;
  row.title = exercise.title;
  row.goal = exercise.goal_message;
  std::array<std::vector<double>, kLevels> totals;
  for (const Attempt& a : history) {
    if (a.damaged || a.exercise != exercise.id || a.level < 1 || a.level > kLevels) continue;
    ++(a.graded() ? row.attempts : row.unfinished);
    row.level = a.level;
    if (!a.graded()) continue;
    const auto at = static_cast<std::size_t>(a.level - 1);
    totals[at].push_back(*a.total);
    row.best[at] = std::max(row.best[at].value_or(0), *a.total);
    row.last = a.total;
  }
  row.totals = std::move(totals[static_cast<std::size_t>(row.level - 1)]);
  row.trend = FindTrend(row.totals);
  row.next = RecommendIn(history, exercise)
                 .value_or(NextStep{NextStep::Kind::kFinished,
                                    exercise.id,
                                    kLevels,
                                    {MarkMessage("All levels of this exercise are passed."), {}}});
  return row;
}

std::vector<ExerciseRow> ListProgress(std::span<const Attempt> history) {
  std::vector<ExerciseRow> rows;
  for (const Exercise& exercise : ListExercises()) rows.push_back(MakeProgress(history, exercise));
  for (const Exercise& procedure : ListProcedures()) rows.push_back(MakeProgress(history, procedure));
  return rows;
}

NextStep FindNextStep(std::span<const Attempt> history) {
  return RecommendFirst(history);
}

std::vector<Aid> ListAids(const SceneExercise& exercise, bool in_plane, bool translucent) {
  return {
      {MarkMessage("Steps"), MarkMessage("The next step of the exercise is said."), exercise.level == 1},
      {MarkMessage("Depth stop"), MarkMessage("The saw is held at the depth of the goal."), exercise.depth_stop},
      {MarkMessage("Tone"), MarkMessage("A tone tells how far the goal is."), exercise.sound},
      {MarkMessage("Colour of the blade"),
       MarkMessage("The blade is green at the goal, and orange or red when it is too deep."), exercise.colour},
      {MarkMessage("Depth gauge and advice"), MarkMessage("The depth is shown, and what to do about it."),
       exercise.gauge},
      {MarkMessage("Plane lock"),
       MarkMessage("The saw stays in the wanted plane; from beside it, it moves only towards the plane."), in_plane},
      {MarkMessage("Translucent bone"), MarkMessage("The nerve canal and the roots can be seen through the bone."),
       translucent}};
}

}  // namespace kerf
