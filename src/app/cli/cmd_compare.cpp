// kerf compare: the same cut in voxel mode and slab mode, and with several force laws.
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/files/folder_lock.h"
#include "experiment/compare/compare_files.h"
#include "experiment/compare/comparison.h"
#include "experiment/compare/conclusion.h"
#include "kerf/error.h"
#include "session/scene/scene.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

struct CompareArguments {
  std::string scene;
  std::string folder = "out/compare";
  CompareParams params;
  bool json = false;
};

void PrintComparison(const Comparison& c, const std::vector<std::string>& files, const std::string& folder) {
  fmt::print("{}\n", c.title.empty() ? c.scene : c.title);
  fmt::print("  {:<28} {:>9} {:>9} {:>9} {:>9} {:>7} {:>9} {:>9} {:>9} {:>10}\n", "", "mean N", "ratio", "peak N",
             "rms N", "rms %", "p50 us", "p99 us", "max us", "memory");
  for (const CaseResult& r : c.cases) {
    const double percent = c.reference().peak_N > 0 ? 100 * r.slice.rms_N / c.reference().peak_N : 0;
    const double ratio = r.slice.reference_mean_N > 0 ? r.slice.mean_N / r.slice.reference_mean_N : 0;
    fmt::print("  {:<28} {:>9} {:>9} {:>9} {:>9} {:>7} {:>9} {:>9} {:>9} {:>10}\n", r.what.label,
               ShowFigure(r.slice.mean_N), ShowFigure(ratio), ShowFigure(r.peak_N), ShowFigure(r.slice.rms_N),
               ShowFigure(percent), ShowFigure(r.times.p50_us), ShowFigure(r.times.p99_us), ShowFigure(r.times.max_us),
               ShowMemory(static_cast<double>(r.memory_bytes)));
  }
  fmt::print(
      "  over the slice of {1:.1f} mm; ratio: mean divided by that of {0}; rms: difference of force from {0}, and in % "
      "of its peak\n",
      c.reference().what.label, c.profile.end_mm);
  fmt::print("  results   {}/:", folder);
  for (const std::string& file : files) fmt::print(" {}", file);
  fmt::print("\n");
}

void Run(const CompareArguments& options) {
  try {
    CheckCompareParams(options.params);
  } catch (const Error& e) {
    throw CLI::ValidationError("--laws", e.what());  // CLI11 has checked the numbers
  }
  RequirePictures();
  const Scene scene = ReadScene(options.scene);
  CheckCompareInputsNotOverwritten(scene, options.scene, options.folder);
  const FolderLock lock(options.folder);  // taken before the long computation
  Comparison comparison;
  {
    StageBars bars;
    const auto show = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    comparison = CompareScene(scene, options.params, show, options.scene);
  }
  const std::vector<std::string> files = WriteComparison(comparison, options.folder);
  for (const std::string& warning : comparison.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatCompareJson(comparison));
  } else {
    PrintComparison(comparison, files, options.folder);
  }
}

}  // namespace

void AddCompareCommand(CLI::App& app) {
  const auto options = std::make_shared<CompareArguments>();
  CLI::App* command = app.add_subcommand(
      "compare", "Make the same cut in voxel mode and slab mode, and report forces, work, time and memory of each");
  command
      ->add_option("SCENE", options->scene,
                   "Scene file (TOML) with a [slab] section; both modes are run, whatever its mode")
      ->required();
  command->add_option("-o,--output", options->folder, "Folder for report, figures, CSV and JSON; created if missing")
      ->capture_default_str();
  command
      ->add_option("--laws", options->params.laws,
                   "Force laws for voxel mode in addition to the scene's, separated by commas, with their default "
                   "parameters; \"all\": every law; default: none")
      ->delimiter(',')
      ->allow_extra_args(false);
  AddNumber(*command, "--depth-step", options->params, "depth_step_mm")->capture_default_str();
  AddNumber(*command, "--repeat", options->params, "repetitions")->capture_default_str();
  command->add_flag("--json", options->json, "Print as JSON (compare.json)");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
