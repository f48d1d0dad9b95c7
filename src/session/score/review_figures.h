// Figures of a review: the measures of an attempt as the student sees them, with their goals and marks.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/core/message.h"
#include "session/score/measures.h"

namespace kerf {

/// Maximum length of a label in characters, so that it fits its column; a translation may be 30 % longer.
inline constexpr std::size_t kMaxLabelLength = 22;
/// Number of figures that are shown first.
inline constexpr std::size_t kReviewFigures = 5;

/// Mark of a figure. A scored figure is good if it costs no points, bad if it costs more than half of those that it can
/// cost, and otherwise a warning. A figure that is not scored is good if it meets its goal, and plain if it has none.
enum class ReviewLevel { kPlain, kGood, kWarn, kBad };

/// How a value should relate to its goal.
enum class GoalRelation { kNone, kEqual, kAtMost, kAtLeast };

/// A measure of the attempt, as the student sees it.
struct ReviewFigure {
  const MeasureInfo* info = nullptr;
  const char* label = "";         // short name, in English
  std::optional<Quantity> value;  // none: could not be measured
  GoalRelation relation = GoalRelation::kNone;
  std::optional<Quantity> goal;  // none: for information only
  ReviewLevel level = ReviewLevel::kPlain;
  bool scored = false;         // can cost points; other figures are marked by their goals
  std::optional<double> lost;  // points of 100 that it cost; none: not scored
  int lost_points = 0;         // the same as a whole number; those of all figures add up to 100 - total, rounded
};

/// Distance from the nerve canal that is good.
inline constexpr double kNerveGood_mm = 2;

struct ReviewFigures {
  std::vector<ReviewFigure> first;  // at most kReviewFigures
  std::vector<ReviewFigure> rest;   // further measures that make sense for the attempt and have a value or cost points
};
/// Returns the figures of an attempt. For a sheet without an exercise, all are in `rest`.
ReviewFigures MakeFigures(const ScoreSheet& sheet);

/// Returns the keys of the figures that matter most in an exercise, the most important first.
std::span<const char* const> KeyFiguresOf(ExerciseKind kind);
/// Returns true if the measure makes sense for the exercise: depth errors only where the goal is a depth, plunge only
/// where the far side can be reached, the nerve only where the cut comes near it.
bool IsMeaningful(const MeasureInfo& info, ExerciseKind kind);
/// Returns true if the nerve must be spared. In an osteotomy, the planned plane crosses it.
bool SparesNerve(ExerciseKind kind);
/// Returns the short English name of a measure.
const char* LabelOf(const MeasureInfo& info);
/// Returns one or two English sentences for students: what the measure says, without technical terms.
const char* MeaningOf(const MeasureInfo& info);
/// Returns a value of the measure with the unit and the decimals to show. A fraction is shown in percent. A value that
/// is not perfect is not shown as if it were: it has more decimals, or is rounded away from the perfect value.
Quantity ShowMeasure(const MeasureInfo& info, double value);
/// Returns the goal with its relation, for example "at most 0.5 mm" as "≤ 0.5 mm"; empty if there is none.
std::string FormatGoal(const ReviewFigure& figure, std::string_view point = ".");
/// Returns the row of a measure, which must exist.
const MeasureRow& RowOf(const ScoreSheet& sheet, std::string_view key);

}  // namespace kerf
