// Panels of `kerf practise`: the exercises and their levels, the aids, the result, and the replay beside the expert.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "session/practise/progress.h"
#include "session/practise/replay_pair.h"
#include "session/score/message.h"
#include "session/score/review.h"
#include "view/picture/colours.h"
#include "view/ui/event.h"
#include "view/ui/ui.h"

namespace kerf {

/// Colours of the attempt, and of the wanted cut and the expert; distinguishable with any colour vision.
inline constexpr Rgb8 kMadeColour{213, 94, 0};
inline constexpr Rgb8 kWantedColour{0, 114, 178};

/// Returns the message in the current language.
std::string Translate(const Message& message);

/// Dialog with the exercises and, once one is chosen, with its levels. Controlled with Up, Down, Enter, Escape, the
/// digits and the mouse. At first, the recommended exercise and level are selected.
class ExerciseList {
 public:
  enum class Choice {
    kNone,
    kStart,  // exercise() at level()
    kName,   // the student wants to enter a name
  };
  /// `rows`: as made by ListProgress(), not empty. `student`: whose attempts are stored; empty: they are not stored.
  ExerciseList(std::vector<ExerciseRow> rows, std::string student);

  /// Takes a pressed key.
  Choice Take(const WindowEvent& event);
  Choice Draw(Ui& ui);
  const std::string& exercise() const { return rows_[row_].id; }
  int level() const { return level_; }
  /// Returns the title of what is shown: the list, or an exercise.
  std::string title() const;

 private:
  void OpenLevels(std::size_t row);
  int FindRecommendedLevel(const ExerciseRow& row) const;
  Choice DrawExercises(Ui& ui);
  Choice DrawLevels(Ui& ui);

  std::vector<ExerciseRow> rows_;
  std::string student_;
  NextStep next_;
  std::size_t row_ = 0;
  int level_ = 1;
  bool shows_levels_ = false;
  bool scrolls_ = true;  // to the selected row, in the next frame
};

/// Section of the left column: the aids that are on.
void DrawAids(Ui& ui, const std::vector<Aid>& aids);

struct ResultContents {
  std::string title;  // of the exercise, in the current language
  int level = 1;      // of the attempt
  const ScoreSheet& sheet;
  const ExerciseReview& review;
  const NextStep& next;
  std::optional<bool> verified;      // whether a replay gave the same sheet; unset: not known yet
  bool verification_failed = false;  // it will not become known
  std::string stored;                // sentence: for whom the attempt is stored, or why it is not
  bool asks_name = false;            // offers to enter a name
  bool expert_ready = false;
};
enum class ResultChoice { kNone, kStep, kAgain, kNextLevel, kReplay, kList, kName };
/// Dialog with the result of an attempt. Returns what was clicked.
ResultChoice DrawResult(Ui& ui, const ResultContents& contents);

enum class ReplayChoice { kNone, kRestart, kBack };
/// Small window at the lower left of the scene: depth over time of both attempts. `goal_mm`: the wanted depth.
/// `time_s`: the time that is shown; changed by a click or a drag in the plot.
ReplayChoice DrawReplay(Ui& ui, const ReplayPair& pair, double goal_mm, double& time_s, const UiBox& scene);

}  // namespace kerf
