#include "session/practise/progress.h"

#include <algorithm>
#include <utility>

namespace kerf {
namespace {

Quantity Points(double total) {
  return {total, 0, ""};
}

/// Returns the exercise after this one; null for the last.
const Exercise* FindNextExercise(const Exercise& exercise) {
  const std::span<const Exercise> all = ListExercises();
  const auto next = static_cast<std::size_t>(&exercise - all.data()) + 1;
  return next < all.size() ? &all[next] : nullptr;
}

NextStep GoOn(const Exercise& exercise, int level, double total) {
  if (level < kLevels) {
    return {NextStep::Kind::kNextLevel,
            exercise.id,
            level + 1,
            {MarkMessage("{0} of 100 points: go on with level {1}, which has one aid less."),
             {Points(total), Points(level + 1)}}};
  }
  if (const Exercise* next = FindNextExercise(exercise)) {
    return {NextStep::Kind::kNextExercise,
            next->id,
            1,
            {MarkMessage("{0} of 100 points without aids: go on with the exercise \"{1}\"."),
             {Points(total), next->title}}};
  }
  return {
      NextStep::Kind::kFinished,
      exercise.id,
      level,
      {MarkMessage("{0} of 100 points in the last exercise without aids: you have done them all."), {Points(total)}}};
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

NextStep Recommend(std::span<const Attempt> history, std::string_view exercise_id, int level) {
  const Exercise& exercise = FindExercise(exercise_id);
  CheckRange("level", level, FindRange<SceneExercise>("level"));
  std::vector<const Attempt*> attempts;
  for (const Attempt& a : history) {
    if (!a.damaged && a.exercise == exercise.id && a.level == level) attempts.push_back(&a);
  }
  const NextStep::Kind again = NextStep::Kind::kRepeat;
  if (attempts.empty()) {
    return {NextStep::Kind::kFirst, exercise.id, level, {MarkMessage("You have not tried this level yet."), {}}};
  }
  const Attempt& last = *attempts.back();
  if (!last.graded()) {
    return {again, exercise.id, level, {MarkMessage("Your last attempt was not graded: try this level again."), {}}};
  }
  if (*last.total >= kGoodTotal) return GoOn(exercise, level, *last.total);
  const bool twice_poor = attempts.size() >= 2 && *last.total < kPoorTotal && attempts[attempts.size() - 2]->graded() &&
                          *attempts[attempts.size() - 2]->total < kPoorTotal;
  if (twice_poor && level > 1) {
    return {NextStep::Kind::kPreviousLevel,
            exercise.id,
            level - 1,
            {MarkMessage("Two attempts below {0} of 100 points: practise level {1} again, which has one more aid."),
             {Points(kPoorTotal), Points(level - 1)}}};
  }
  return {again,
          exercise.id,
          level,
          {MarkMessage("{0} of 100 points: try this level again, and go on from {1} points."),
           {Points(*last.total), Points(kGoodTotal)}}};
}

std::vector<ExerciseRow> ListProgress(std::span<const Attempt> history) {
  std::vector<ExerciseRow> rows;
  for (const Exercise& exercise : ListExercises()) {
    ExerciseRow row;
    row.id = exercise.id;
    row.title = exercise.title;
    row.goal = exercise.goal_message;
    std::array<std::vector<double>, kLevels> totals;
    for (const Attempt& a : history) {
      if (a.damaged || a.exercise != exercise.id || a.level < 1 || a.level > kLevels) continue;
      ++row.attempts;
      row.level = a.level;
      if (!a.graded()) continue;
      const auto at = static_cast<std::size_t>(a.level - 1);
      totals[at].push_back(*a.total);
      row.best[at] = std::max(row.best[at].value_or(0), *a.total);
      row.last = a.total;
    }
    row.totals = std::move(totals[static_cast<std::size_t>(row.level - 1)]);
    row.trend = FindTrend(row.totals);
    row.next = Recommend(history, exercise.id, row.level);
    rows.push_back(std::move(row));
  }
  return rows;
}

NextStep FindNextStep(std::span<const Attempt> history, std::span<const ExerciseRow> rows) {
  const auto counts = [&](const Attempt& a) {
    const bool known = std::any_of(rows.begin(), rows.end(), [&](const ExerciseRow& r) { return r.id == a.exercise; });
    return known && !a.damaged && a.level >= 1 && a.level <= kLevels;
  };
  const auto last = std::find_if(history.rbegin(), history.rend(), counts);
  if (last != history.rend()) {
    NextStep next = Recommend(history, last->exercise, last->level);
    if (next.kind != NextStep::Kind::kFinished) return next;
  }
  for (const ExerciseRow& row : rows) {
    if (row.next.exercise == row.id && row.next.kind != NextStep::Kind::kFinished) return row.next;
  }
  return rows.empty() ? NextStep{} : rows.back().next;
}

std::vector<Aid> ListAids(const SceneExercise& exercise, bool in_plane, bool translucent) {
  return {{MarkMessage("Steps"), MarkMessage("The next step of the exercise is said."), exercise.level == 1},
          {MarkMessage("Depth stop"), MarkMessage("The saw is held at the depth of the goal."), exercise.depth_stop},
          {MarkMessage("Tone"), MarkMessage("A tone tells how far the goal is."), exercise.sound},
          {MarkMessage("Colour of the blade"),
           MarkMessage("The blade is green at the goal, and orange or red when it is too deep."), exercise.colour},
          {MarkMessage("Depth gauge and advice"), MarkMessage("The depth is shown, and what to do about it."),
           exercise.gauge},
          {MarkMessage("Plane lock"), MarkMessage("The saw moves only in the plane of its blade."), in_plane},
          {MarkMessage("Translucent bone"), MarkMessage("The nerve canal and the roots can be seen through the bone."),
           translucent}};
}

}  // namespace kerf
