// Entries of the menu of exercises, keys and tour.
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "app/window/practice.h"
#include "session/practise/exercises.h"
#include "view/ui/translate.h"

namespace kerf {
namespace {

// When keys of the exercises have their meaning.
constexpr const char* kCuttingKeys = Msg("while cutting");
constexpr const char* kResultKeys = Msg("at the result");
constexpr const char* kReplayKeys = Msg("in the replay");
constexpr const char* kListKeys = Msg("in the list");

}  // namespace

void Practice::AddActions(ActionList& actions) {
  actions.Add({.id = "file.open",
               .menu = Msg("File"),
               .label = Msg("Open an exercise"),
               .shortcut = {.key = Key::kO, .control = true},
               .tip = Msg("A scene with a section [exercise] (.toml); or drop it here"),
               .run = [this] { AskOpen(); },
               .enabled = [this] { return state_ != State::kCutting && state_ != State::kScoring; }});
  actions.Add({.id = "exercise.finish",
               .menu = Msg("Exercise"),
               .label = Msg("Finish and see the score"),
               .shortcut = {Key::kEnter},
               .when = kCuttingKeys,
               .run = [this] { AskToFinish(true); },
               .enabled = [this] { return state_ == State::kCutting && viewer_->is_running(); },
               .relevant = [this] { return state_ == State::kCutting; },
               .button = Msg("Finish")});
  actions.Add({.id = "exercise.leave",
               .menu = Msg("Exercise"),
               .label = Msg("Leave without a score"),
               .shortcut = {Key::kEscape},
               .when = kCuttingKeys,
               .run = [this] { AskToFinish(false); },
               .enabled = [this] { return state_ == State::kCutting && viewer_->is_running(); }});
  const auto replays = [this] { return state_ == State::kReplaying; };
  const auto at_result = [this] { return state_ == State::kResult; };
  actions.Add({.id = "exercise.step",
               .menu = Msg("Exercise"),
               .label = Msg("Recommended next step"),
               .shortcut = {Key::kEnter},
               .when = kResultKeys,
               .run = [this] { DoNextStep(); },
               .enabled = at_result,
               .relevant = at_result,
               .button = Msg("Next step")});
  actions.Add({.id = "exercise.again",
               .menu = Msg("Exercise"),
               .label = Msg("Try again"),
               .shortcut = {Key::kA},
               .when = kResultKeys,
               .run = [this] { Start(exercise_->id, options_.level); },
               .enabled = at_result,
               .relevant = at_result,
               .button = Msg("Try again")});
  actions.Add({.id = "exercise.replay",
               .menu = Msg("Exercise"),
               .label = Msg("Watch the attempt beside the expert's"),
               .shortcut = {Key::kW},
               .when = kResultKeys,
               .run = [this] { Replay(); },
               .enabled = at_result,
               .relevant = at_result,
               .button = Msg("Watch")});
  actions.Add({.id = "exercise.restart_replay",
               .menu = Msg("Exercise"),
               .label = Msg("Watch from the beginning"),
               .shortcut = {Key::kEnter},
               .when = kReplayKeys,
               .run = [this] { RestartReplay(); },
               .enabled = replays});
  actions.Add({.id = "exercise.pause_replay",
               .menu = Msg("Exercise"),
               .label = Msg("Pause, or go on"),
               .shortcut = {Key::kSpace},
               .when = kReplayKeys,
               .run = [this] { PauseReplay(); },
               .enabled = replays,
               .on = [this] { return replay_runs_; },
               .relevant = replays,
               .indicator = Msg("Replay"),
               .state = [this] { return replay_runs_ ? Tr("running") : Tr("paused"); }});
  actions.Add({.id = "exercise.end_replay",
               .menu = Msg("Exercise"),
               .label = Msg("Return to the result"),
               .shortcut = {Key::kEscape},
               .when = kReplayKeys,
               .run = [this] { EndReplay(); },
               .enabled = replays,
               .relevant = replays,
               .button = Msg("Back to the result")});
  actions.Add({.id = "exercise.next",
               .menu = Msg("Exercise"),
               .label = Msg("Next level"),
               .shortcut = {Key::kN},
               .when = kResultKeys,
               .run = [this] { Start(exercise_->id, options_.level + 1); },
               .enabled = [this] { return state_ == State::kResult && options_.level < kLevels; }});
  actions.Add({.id = "exercise.list",
               .menu = Msg("Exercise"),
               .label = Msg("Other exercises"),
               .shortcut = {Key::kEscape},
               .when = kResultKeys,
               .run = [this] { Choose(); },
               .enabled = [this] { return state_ == State::kResult; }});
}

void Practice::AskOpen() {
  viewer_->dialogs().ChooseFile(viewer_->ui(), Tr("Open a scene with an exercise"),
                                FindRecentFolder(viewer_->settings()), {".toml"}, false, "",
                                [this](const std::string& path) { Open(path); });
}

std::vector<HudKeyGroup> Practice::help() const {
  std::vector<HudKeyGroup> groups{
      {ShowKeyGroup("Exercise", kReplayKeys), {{Tr("Left, Right"), Tr("back, forward by 0.5 s")}}}};
  if (cuts()) return groups;
  HudKeyGroup saw = saw_help();
  saw.title = ShowKeyGroup(Msg("Moving the saw"), kCuttingKeys);
  groups.push_back(std::move(saw));
  groups.push_back({ShowKeyGroup("Exercise", kListKeys),
                    {{Tr("Up, Down"), Tr("another exercise or level")},
                     {Tr("Enter"), Tr("show its levels, or begin a level")},
                     {fmt::format("1\u2013{}", std::min<std::size_t>(9, MakeRows().size())),
                      Tr("exercise or level with this number")},
                     {"N", Tr("another student")}}});
  return groups;
}

std::vector<TourStep> Practice::tour() const {
  std::vector<TourStep> steps;
  if (state_ == State::kChoosing) {
    steps.push_back(
        {.title = Tr("Choose an exercise"),
         .text = Tr("Click the blue button to begin with the recommended exercise. Or choose one with Up and Down, and "
                    "press Enter twice. Each level has fewer aids than the one before. The numbers are your best "
                    "scores."),
         .action = "choose",
         .has_button = false});
  }
  steps.push_back(
      {Tr("Cut"),
       Tr("Space switches the spindle on and off. Move the saw with the arrow keys, or by dragging with the left "
          "mouse button. The card at the top says the next step, and the left column shows the depth. The clock "
          "starts when you move the saw or switch the spindle on."),
       "cut"});
  steps.push_back(
      {Tr("See how you did"),
       Tr("Enter finishes the exercise. The first sentence of the result says what to do better. W shows your saw "
          "beside that of the expert, and A tries again. F1 shows all keys, and this tour is in the menu Help."),
       "result"});
  return steps;
}

}  // namespace kerf
