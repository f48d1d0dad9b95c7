// Panels of `kerf practise`: the aids, the result, and the replay beside the expert.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "session/marks/structures.h"
#include "session/practise/progress.h"
#include "session/practise/replay_pair.h"
#include "session/score/review.h"
#include "session/watch/cut_watch.h"
#include "view/ui/ui.h"

namespace kerf {

/// Sections of the left column: what a planned plane crosses and has been cut, what was injured outside the wanted cut,
/// and the aids that are on.
void DrawCrossed(Ui& ui, const PlanesReport& report);
void DrawAids(Ui& ui, const std::vector<Aid>& aids);

struct ResultContents {
  std::string title;  // of the exercise, in the current language
  int level = 1;      // of the attempt
  const ScoreSheet& sheet;
  const ExerciseReview& review;
  const NextStep& next;
  std::optional<bool> verified;      // whether a replay gave the same sheet; unset: not known yet
  bool verification_failed = false;  // it will not become known
  std::string holder{};              // sentence: what holds the tool was inside the bone; empty: it was not
  std::string stored;                // sentence: for whom the attempt is stored, or why it is not
  bool asks_name = false;            // offers to enter a name
  bool expert_ready = false;
  std::optional<double> waits_s;  // how long the replay has been waiting for the expert's attempt
};
enum class ResultChoice { kNone, kStep, kAgain, kNextLevel, kReplay, kList, kName };
/// Dialog with the result of an attempt. Returns what was clicked.
ResultChoice DrawResult(Ui& ui, const ResultContents& contents);

/// Returns the place of the replay's window in the scene: all of it with an explanation if there is room, otherwise a
/// lower one, in a very low scene without the plot. Empty: there is no room for it.
UiBox CalcReplayBox(const Ui& ui, const ReplayPair& pair, double counted_s, const UiBox& scene);

enum class ReplayChoice { kNone, kRestart, kPause, kBack };
/// Small window at the lower left of the scene: depth over time of both attempts. `goal_mm`: the wanted depth.
/// `counted_s`: the attempt's time in the result, of which the replay shows a part. `runs`: the time goes on.
/// `time_s`: the time that is shown; changed by the slider, and by a click or a drag in the plot.
ReplayChoice DrawReplay(Ui& ui, const ReplayPair& pair, double goal_mm, double counted_s, bool runs, double& time_s,
                        const UiBox& scene);

}  // namespace kerf
