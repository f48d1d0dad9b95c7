// A student's progress: best scores, trend and next step, from the history. Pure.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/core/message.h"
#include "session/practise/exercises.h"
#include "session/practise/history.h"

namespace kerf {

enum class Trend {
  kUnknown,  // fewer than kMinTrendAttempts graded attempts
  kRising,
  kSteady,
  kFalling,
};

/// Number of graded attempts from which a trend is stated, and the number of the last ones that it considers.
inline constexpr std::size_t kMinTrendAttempts = 3;
inline constexpr std::size_t kMaxTrendAttempts = 6;
/// Change of the total along the regression line, from the first to the last of these attempts, from which they rise or
/// fall.
inline constexpr double kTrendPoints = 5;
/// Total, out of 100, below which the previous level is recommended after two such attempts in a row.
inline constexpr double kPoorTotal = 30;

/// Returns the trend of totals in the order of the attempts: the sign of the regression line's slope, if it changes by
/// at least kTrendPoints over the last attempts, at most kMaxTrendAttempts of them.
Trend FindTrend(std::span<const double> totals);

/// What to do next.
struct NextStep {
  enum class Kind {
    kFirst,   // first attempt at this level
    kRepeat,  // the same level again
    kNextLevel,
    kPreviousLevel,  // with more aids
    kNextExercise,
    kFinished,  // all levels are passed
  };
  Kind kind = Kind::kFirst;
  std::string exercise;  // id
  int level = 1;
  Message reason;  // one sentence

  bool operator==(const NextStep&) const = default;
};

/// Recommends the next step after an attempt at an exercise and level. `total`: its score; none: it has none. Below
/// kGoodTotal, the same level, or after two attempts below kPoorTotal in a row the previous one. From kGoodTotal on,
/// the first level of the exercise that is not passed, or if there is none, that of FindNextStep(). A level is passed
/// if the best total of all attempts at it, or at a higher level of the exercise, is at least kGoodTotal; of an
/// osteotomy, that of all attempts that cut the bone through. `history`: attempts of one student in the order of
/// submission, with this one as the last, unless nothing was cut; damaged rows are ignored. Throws kerf::Error for a
/// level out of range.
NextStep Recommend(std::span<const Attempt> history, const Exercise& exercise, int level, std::optional<double> total);
/// The same for a built-in exercise. Throws kerf::Error for an unknown one, too.
NextStep Recommend(std::span<const Attempt> history, std::string_view exercise, int level, std::optional<double> total);

/// Row of the list of exercises.
struct ExerciseRow {
  std::string id;
  std::string title;
  Message goal;
  std::size_t attempts = 0;                           // graded
  std::size_t unfinished = 0;                         // not graded
  std::array<std::optional<double>, kLevels> best{};  // best total of each level
  std::optional<double> last;                         // total of the last graded attempt
  std::vector<double> totals;                         // of the graded attempts at `level`, in their order
  int level = 1;                                      // of the last attempt; 1 without any
  Trend trend = Trend::kUnknown;                      // of the graded attempts at this level
  NextStep next;
};

/// Returns the row of an exercise. `history`: as in Recommend().
ExerciseRow MakeProgress(std::span<const Attempt> history, const Exercise& exercise);
/// Returns a row for each of ListExercises(), from easy to hard, and for each of ListProcedures().
std::vector<ExerciseRow> ListProgress(std::span<const Attempt> history);

/// Returns the step to begin with: the first level that is not passed, in the order of the exercises.
NextStep FindNextStep(std::span<const Attempt> history);

/// Aids of a level.
struct Aid {
  const char* name;  // "Depth gauge"
  const char* what;  // one sentence
  bool on = false;
};
/// Returns all aids, and which of them the exercise has at its level. `in_plane`: the motion is restricted to the
/// blade's plane; `translucent`: the nerve canal can be seen through the bone.
std::vector<Aid> ListAids(const SceneExercise& exercise, bool in_plane, bool translucent);

}  // namespace kerf
