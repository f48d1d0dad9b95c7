// kerf rehearse: a free cut in a window.
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/numbers.h"
#include "app/cli/signals.h"
#include "app/cli/window_options.h"
#include "app/window/rehearsal.h"
#include "base/files/files.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string input;
  WindowOptions window;
  std::vector<std::string> plans;
  std::string saws;
  double voxel_mm = 0.2;
  bool obj = false;
  bool watch = false;
  bool json = false;
};

void Run(const Options& options) {
  RehearsalOptions rehearsal;
  rehearsal.theatre = MakeTheatreOptions(options.window, "kerf rehearse", "rehearsal");
  rehearsal.theatre.scripted = options.watch;
  rehearsal.input = options.input;
  rehearsal.obj = options.obj;
  rehearsal.open = {.folder = rehearsal.theatre.folder, .voxel_mm = options.voxel_mm};
  rehearsal.plans = options.plans;
  rehearsal.saws = options.saws.empty() ? BuiltInSaws() : ParseSaws(ReadTextFile(options.saws), options.saws);
  if (!options.input.empty() && !std::filesystem::exists(options.input)) {
    throw Error(fmt::format("{}: there is no such file or folder", options.input));
  }
  Rehearsal theatre(rehearsal);
  const ExitsAtOnce at_once;
  const RehearsalResult result = theatre.Run();
  if (options.json) {
    fmt::print("{}\n", nlohmann::json{{"folder", rehearsal.theatre.folder},
                                      {"recordings", result.recordings},
                                      {"take_away", result.take_away}}
                           .dump(2));
    return;
  }
  for (const std::string& recording : result.recordings) fmt::print("recording  {}\n", recording);
  if (!result.take_away.empty()) fmt::print("taken away {}\n", result.take_away);
}

}  // namespace

void AddRehearseCommand(CLI::App& app) {
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("rehearse", "Cut a bone freely in a window, by mouse and keys");
  command->add_option("input", options->input,
                      "A scene (.toml), a bone (.vdb), a folder with a DICOM series, or any file that 'kerf import' "
                      "takes; without it the generic mandible");
  command->add_option("--plan", options->plans, "Planes to cut along, of 3D Slicer (.mrk.json); may be given again");
  command->add_option("--saws", options->saws, "Table of saws to switch among, columns as volumes/saws.csv");
  command->add_option("--voxel", options->voxel_mm, "Voxels of a bone that is imported")
      ->check(NumberWithin(0.05, 2, "mm"))
      ->capture_default_str();
  CLI::Option* watch =
      command->add_flag("--watch", options->watch,
                        "The scene's own hand goes along its path, as in 'kerf loop'; the mouse has the view alone");
  command->add_flag("--obj", options->obj, "Pieces are taken away as OBJ, not as STL");
  AddWindowOptions(*command, options->window);
  watch->excludes("--device");
  command->add_flag("--json", options->json, "What was left behind, as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
