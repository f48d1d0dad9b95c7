// Review of an attempt in words: what to do better, what was good, the figures that matter, and the rest.
#pragma once

#include <optional>
#include <vector>

#include "base/core/message.h"
#include "session/score/measures.h"
#include "session/score/review_figures.h"

namespace kerf {

struct ExerciseReview {
  std::optional<Message> passed;  // the level is passed; said before the headline
  Message headline;               // the improvement that is worth most, or what prevents a score
  std::optional<Message> praise;  // what was good: neither the subject of the headline nor what cost points
  std::optional<Message> nerve;   // what happened to a nerve canal in a planned cut, and how far it is from the plan
  std::vector<Message> crossed;   // the other structures that were cut as planned
  std::vector<Message> notes;     // what else the student should know, such as that the time was up
  std::vector<ReviewFigure> figures;  // at most kReviewFigures
  std::vector<ReviewFigure> rest;  // further measures that make sense for the attempt and have a value or cost points
};

/// Reviews an attempt at an exercise; pure. For a sheet without an exercise, the headline says so and all measures are
/// in `rest`.
ExerciseReview MakeReview(const ScoreSheet& sheet);

}  // namespace kerf
