// Review of an attempt in words: what to do better, what was good, the figures that matter, and the rest.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "session/score/measures.h"
#include "session/score/message.h"

namespace kerf {

/// Maximum length of a label in characters, so that it fits its column; a translation may be 30 % longer.
inline constexpr std::size_t kMaxLabelLength = 22;
/// Number of figures that are shown first.
inline constexpr std::size_t kReviewFigures = 5;

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
  std::optional<double> lost;  // points of 100 that it cost; none: not scored
  int lost_points = 0;         // the same as a whole number; those of all figures add up to 100 - total, rounded
};

struct ExerciseReview {
  Message headline;                   // the improvement that is worth most, or what prevents a score
  std::optional<Message> praise;      // what was good
  std::optional<Message> nerve;       // what happened to a nerve canal that the planned cut crosses
  std::vector<ReviewFigure> figures;  // at most kReviewFigures
  std::vector<ReviewFigure> rest;  // further measures that make sense for the attempt and have a value or cost points
};

/// Returns the keys of the figures that matter most in an exercise, the most important first.
std::span<const char* const> KeyFiguresOf(ExerciseKind kind);
/// Returns true if the measure makes sense for the exercise: depth errors only where the goal is a depth, plunge only
/// where the far side can be reached, the nerve only where the cut comes near it.
bool IsMeaningful(const MeasureInfo& info, ExerciseKind kind);
/// Returns true if the nerve must be spared. In an osteotomy, the planned plane crosses it.
bool SparesNerve(ExerciseKind kind);
/// Returns the short English name of a measure.
const char* LabelOf(const MeasureInfo& info);
/// Returns a value of the measure with the unit and the decimals to show. A fraction is shown in percent.
Quantity ShowMeasure(const MeasureInfo& info, double value);
/// Returns the goal with its relation, for example "at most 0.5 mm" as "≤ 0.5 mm"; empty if there is none.
std::string FormatGoal(const ReviewFigure& figure, std::string_view point = ".");

/// Aspects of a cut that cost points.
enum class Fault {
  kMissing,  // part of the wanted cut was not made
  kBeside,   // the cut lies beside the wanted one
  kTilted,   // it has another direction
  kTooDeep,
  kTooShallow,
  kPlunge,   // beyond the far side
  kOutside,  // bone removed outside the wanted cut
  kNerve,
  kTrembling,
  kLongPath,
  kSlow,
};
struct FaultLoss {
  Fault fault;
  double lost = 0;  // points of 100
};
/// Returns what cost points in a graded attempt, the largest loss first; the losses add up to 100 - total. Points for
/// bone that is missing or was removed outside are attributed to the position if the cut lies beside the wanted one by
/// more than the margin, because moving it would regain them. Returns nothing for a sheet without a total.
std::vector<FaultLoss> FindLosses(const ScoreSheet& sheet);

/// Reviews an attempt at an exercise; pure. For a sheet without an exercise, the headline says so and all measures are
/// in `rest`.
ExerciseReview MakeReview(const ScoreSheet& sheet);

}  // namespace kerf
