// kerf practise: opens a window with exercises for students.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/practise_history.h"
#include "app/cli/signals.h"
#include "app/cli/window_options.h"
#include "app/window/practice.h"
#include "base/files/folder_lock.h"
#include "session/practise/history.h"

namespace kerf::cli {
namespace {

void OpenWindow(const PractiseOptions& options, const WindowOptions& window) {
  PracticeOptions practice;
  practice.viewer = MakeViewerOptions(window, "kerf practise", "practice");
  practice.exercise = options.exercise;
  practice.level = options.level;
  practice.student = options.student;
  Practice viewer(practice);
  const ExitsAtOnce at_once;
  for (const std::string& recording : viewer.Run()) fmt::print("recording  {}\n", recording);
  if (!viewer.left_work()) return;
  practice.viewer.lock->RemoveFolderIfUnused();
  EndAtOnceWith(std::fflush(stdout) == 0 ? 0 : kFailed);
}

/// Throws if an option of the window was given although no window opens.
void RefuseWindowOptions(const std::vector<const CLI::Option*>& of_window) {
  for (const CLI::Option* option : of_window) {
    if (option->count() == 0) continue;
    throw CLI::ValidationError(option->get_name(),
                               "is only for the window, which this command does not open; --record FILE names the "
                               "recording of --agent");
  }
}

}  // namespace

void AddPractiseCommand(CLI::App& app) {
  const auto options = std::make_shared<PractiseOptions>();
  CLI::App* command =
      app.add_subcommand("practise", "Do exercises in a window, score them and show their history (docs/practise.md)");
  const auto window = std::make_shared<WindowOptions>();
  AddPractiseHistoryOptions(*command, *options);
  const std::vector<const CLI::Option*> others = std::as_const(*command).get_options();
  AddWindowOptions(*command, *window);
  std::vector<const CLI::Option*> of_window = std::as_const(*command).get_options();
  std::erase_if(of_window, [&](const CLI::Option* o) { return std::ranges::find(others, o) != others.end(); });
  command->callback([options, window, of_window] {
    if (!options->student.empty()) CheckStudentName(options->student);
    if (WantsPractiseHistory(*options)) {
      RefuseWindowOptions(of_window);
      RunPractiseHistory(*options);
    } else {
      OpenWindow(*options, *window);
    }
  });
}

}  // namespace kerf::cli
