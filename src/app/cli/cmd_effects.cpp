// kerf effects: what a scene may ask for, and what it costs there.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/core/nearest_name.h"
#include "base/files/files.h"
#include "experiment/effect_costs/effect_costs.h"
#include "kerf/error.h"
#include "session/run/run_scene.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string scene;
  EffectCostOptions measure;
  std::optional<double> voxel_mm;
  std::string csv;
  bool as_run = false;
  bool json = false;
  bool markdown = false;
};

void SetVoxel(Scene& scene, double voxel_mm) {
  switch (scene.bone.source) {
    case BoneSource::kMandible:
      scene.bone.mandible.voxel_mm = voxel_mm;
      return;
    case BoneSource::kBlock:
    case BoneSource::kPlate:
      scene.bone.block.voxel_mm = voxel_mm;
      return;
    case BoneSource::kFile:
      break;
  }
  throw Error("--voxel is for a bone that the scene generates; this one is read from a file");
}

/// Throws Error for a word that can't be meant as a file: the nearest effect, or that there are such names.
void RefuseUnknownName(const std::string& word) {
  const std::filesystem::path path(word);
  if (path.has_extension() || path.has_parent_path()) return;
  std::vector<std::string> names;
  for (const EffectInfo* info : Effects()) names.emplace_back(info->name);
  const std::string nearest = FindNearestName(word, names);
  throw Error(fmt::format("there is neither an effect nor a scene file \"{}\"; {}", word,
                          nearest.empty() ? fmt::format("the effects are {}", fmt::join(names, ", "))
                                          : fmt::format("the nearest effect is \"{}\"", nearest)));
}

void Run(Options& options) {
  if (options.scene.empty()) {
    if (options.measure.all || options.markdown || !options.csv.empty() || options.voxel_mm) {
      throw CLI::ValidationError("SCENE", "is missing: give the scene to measure on");
    }
    fmt::print("{}", options.json ? FormatEffectListJson() : FormatEffectList());
    return;
  }
  if (!std::filesystem::exists(options.scene)) {
    if (const EffectInfo* only = FindEffect(options.scene)) {
      fmt::print("{}", options.json ? FormatEffectListJson(only) : FormatEffectList(only));
      return;
    }
    RefuseUnknownName(options.scene);
  }
  Scene scene = ReadScene(options.scene);
  if (options.voxel_mm) SetVoxel(scene, *options.voxel_mm);
  if (!options.csv.empty()) {
    CheckInputsStay(ListInputs(scene, options.scene), {options.csv});
    CheckWritable(options.csv);
  }
  options.measure.by_hand = !options.as_run;
  options.measure.stop = &CatchInterrupt();
  EffectCosts costs;
  {
    StageBars bars;
    options.measure.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    costs = MeasureEffects(scene, options.measure);
  }
  if (!options.csv.empty()) WriteTextFile(options.csv, FormatKeptCosts(costs));
  fmt::print("{}", options.json       ? FormatEffectCostsJson(costs)
                   : options.markdown ? FormatEffectCostsMarkdown(costs)
                                      : FormatEffectCosts(costs));
}

}  // namespace

void AddEffectsCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "effects",
      "List the effects that a scene may name; with a scene, which of them are on, why, and what each costs there");
  command->add_option(
      "SCENE", options->scene,
      "The scene file: its cut is made with and without each effect, in turn, and timed; or an effect's name, "
      "to list that one");
  command->add_option("--seconds", options->measure.seconds, "Of the cut that is timed, where most teeth are engaged")
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
  command->add_option("--passes", options->measure.passes, "Times through it, 1 to 100")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_flag("--run", options->as_run, "The tool led along its path, as by 'kerf run', not in a hand");
  command->add_flag("--all", options->measure.all,
                    "All effects that there are: those that the scene does not name with their presets");
  command->add_flag("--together", options->measure.together_only, "Only all together, not each by itself");
  command->add_option("--voxel", options->voxel_mm, "Voxels of so many mm, instead of the scene's, 0.02 to 4")
      ->check(CLI::Range(0.02, 4.0));
  CLI::Option* core =
      command->add_option("--core", options->measure.core, "Core that the ticks are held to, from 0; without, any")
          ->check(CLI::Range(0, 4095));
  command->add_flag("--realtime", options->measure.realtime, "Let the ticks go before other programs (SCHED_FIFO)")
      ->needs(core);
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--markdown", options->markdown, "Print as the Markdown table of the README")->excludes(json);
  command->add_option("--csv", options->csv, "Also write the costs to this file (volumes/effect_costs.csv)");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
