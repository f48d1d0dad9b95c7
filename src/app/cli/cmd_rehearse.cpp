// kerf rehearse: lets the user cut freely in a window.
#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/link_option.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/signals.h"
#include "app/cli/window_options.h"
#include "app/window/rehearsal.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "bone/import/import.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

struct RehearseArguments {
  std::string input;
  WindowOptions window;
  LinkOption link;
  std::vector<std::string> plans;
  std::string saws;
  double voxel_mm = 0.2;
  bool obj = false;
  bool watch = false;
  bool json = false;
};

void Print(const RehearsalResult& result, const std::string& folder, bool json) {
  if (json) {
    fmt::print("{}\n", nlohmann::json{{"folder", folder},
                                      {"recordings", result.recordings},
                                      {"take_away", result.take_away},
                                      {"exports", result.exports},
                                      {"project", result.project}}
                           .dump(2));
    return;
  }
  for (const std::string& recording : result.recordings) fmt::print("recording  {}\n", recording);
  for (const std::string& folder_of_export : result.exports) fmt::print("exported   {}\n", folder_of_export);
  if (!result.project.empty()) fmt::print("project    {}\n", result.project);
}

void Run(RehearseArguments& options) {
  const std::shared_ptr<SlicerLink> link = OpenLink(options.link);
  if (link) options.window.device.tracked_tool = link->tracked_tool();
  RehearsalOptions rehearsal;
  rehearsal.viewer = MakeViewerOptions(options.window, "kerf rehearse", "rehearsal");
  rehearsal.viewer.scripted = options.watch;
  rehearsal.viewer.link = link;
  rehearsal.input = options.input;
  rehearsal.obj = options.obj;
  rehearsal.voxel_mm = options.voxel_mm;
  rehearsal.plans = options.plans;
  rehearsal.saws = options.saws.empty() ? BuiltInSaws() : ParseSaws(ReadTextFile(options.saws), options.saws);
  if (!options.input.empty() && !std::filesystem::exists(options.input)) {
    throw Error(fmt::format("{}: there is no such file or folder", options.input));
  }
  Rehearsal viewer(rehearsal);
  const ExitsAtOnce at_once;
  const RehearsalResult result = viewer.Run();
  if (link) {
    link->End("the rehearsal has ended");
    SayLinkCounts(*link);
  }
  for (const std::string& warning : result.warnings) SayWarning("{}", warning);
  Print(result, rehearsal.viewer.folder, options.json);
  const std::string failure = fmt::format("{}", fmt::join(result.failures, "\n"));
  if (!result.left_work) {
    if (!failure.empty()) throw Error(failure);
    return;
  }
  if (!failure.empty()) Say("{}", failure);
  rehearsal.viewer.lock->RemoveFolderIfUnused();
  EndAtOnceWith(std::fflush(stdout) == 0 && failure.empty() ? 0 : kFailed);
}

}  // namespace

void AddRehearseCommand(CLI::App& app) {
  auto options = std::make_shared<RehearseArguments>();
  CLI::App* command = app.add_subcommand("rehearse", "Cut a bone freely in a window, with mouse and keys");
  command->add_option("INPUT", options->input,
                      "Scene (.toml), bone (.vdb), folder with a DICOM series, or any file that 'kerf import' reads; "
                      "default: the generic mandible");
  command->add_option(
      "--plan", options->plans,
      "Planes to cut along, from 3D Slicer (.mrk.json, a folder of these, or a scene .mrml); may be repeated");
  command->add_option("--saws", options->saws,
                      "Table of saws to choose from, such as volumes/saws.csv (docs/window.md)");
  AddNumberOption(*command, "--voxel", options->voxel_mm, "voxel_mm", FindRange<ImportOptions>("voxel_mm"),
                  "voxel size of an imported bone")
      ->capture_default_str();
  CLI::Option* watch =
      command->add_flag("--watch", options->watch,
                        "Let the scene's hand follow its path, as in 'kerf loop'; the mouse only changes the view");
  command->add_flag("--obj", options->obj, "Write pieces as OBJ instead of STL");
  AddWindowOptions(*command, options->window);
  watch->excludes("--device");
  AddLinkOption(*command, options->link);
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
