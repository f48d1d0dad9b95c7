// Commands of components that are not in this build. Each is listed in the help and, when it is run, reports that it is
// missing.
#include <string>

#include "app/cli/commands.h"
#include "app/cli/run_uncertain.h"
#include "base/core/not_built.h"
#include "kerf_components.h"

namespace kerf::cli {

#if !(KERF_WITH_WINDOW && KERF_WITH_EXPERIMENTS)
namespace {

void AddAbsent(CLI::App& app, const char* name, const char* option) {
  CLI::App* command = app.add_subcommand(name, std::string("Not in this build (") + option + "=OFF)");
  command->allow_extras();
  command->callback([name, option] { FailNotBuilt((std::string("the command ") + name).c_str(), option); });
}

}  // namespace
#endif

#if !KERF_WITH_WINDOW
void AddRehearseCommand(CLI::App& app) {
  AddAbsent(app, "rehearse", "KERF_WITH_WINDOW");
}
void AddPractiseCommand(CLI::App& app) {
  AddAbsent(app, "practise", "KERF_WITH_WINDOW");
}
#endif

#if !KERF_WITH_EXPERIMENTS
void AddBenchCommand(CLI::App& app) {
  AddAbsent(app, "bench", "KERF_WITH_EXPERIMENTS");
}
void AddCalibrateCommand(CLI::App& app) {
  AddAbsent(app, "calibrate", "KERF_WITH_EXPERIMENTS");
}
void AddCompareCommand(CLI::App& app) {
  AddAbsent(app, "compare", "KERF_WITH_EXPERIMENTS");
}
void AddEffectsCommand(CLI::App& app) {
  AddAbsent(app, "effects", "KERF_WITH_EXPERIMENTS");
}
void AddStabilityCommand(CLI::App& app) {
  AddAbsent(app, "stability", "KERF_WITH_EXPERIMENTS");
}
void AddStudyCommand(CLI::App& app) {
  AddAbsent(app, "study", "KERF_WITH_EXPERIMENTS");
}
void AddTuneCommand(CLI::App& app) {
  AddAbsent(app, "tune", "KERF_WITH_EXPERIMENTS");
}
void AddValidateCommand(CLI::App& app) {
  AddAbsent(app, "validate", "KERF_WITH_EXPERIMENTS");
}
std::function<bool(const UncertainRequest&)> AddUncertainOptions(CLI::App& command, const std::vector<CLI::Option*>&) {
  const CLI::Option* uncertain =
      command.add_option("--uncertain", "Not in this build (KERF_WITH_EXPERIMENTS=OFF)")->expected(1);
  return [uncertain](const UncertainRequest&) {
    if (uncertain->count() > 0) FailNotBuilt("the option --uncertain", "KERF_WITH_EXPERIMENTS");
    return false;
  };
}
#endif

}  // namespace kerf::cli
