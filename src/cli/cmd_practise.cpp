// kerf practise: the student's exercises.
#include <memory>

#include "cli/commands.h"
#include "cli/practise_history.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

/// What is done when nothing else is asked for: the window.
void OpenWindow(const PractiseOptions&) {
  throw Error("kerf practise: this build has no window; --list, --agent, --hand-in, --history and --report need none");
}

}  // namespace

void AddPractiseCommand(CLI::App& app) {
  const auto options = std::make_shared<PractiseOptions>();
  CLI::App* command =
      app.add_subcommand("practise", "Exercises for students, their scores and their history (docs/practise.md)");
  AddPractiseHistoryOptions(*command, *options);
  command->callback([options] {
    if (WantsPractiseHistory(*options)) {
      RunPractiseHistory(*options);
    } else {
      OpenWindow(*options);
    }
  });
}

}  // namespace kerf::cli
