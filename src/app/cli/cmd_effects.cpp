// kerf effects: lists the effects that a scene may use, and what they cost in it.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/numbers.h"
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

struct EffectsArguments {
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
  throw Error("--voxel applies only to a generated bone; this scene reads its bone from a file");
}

/// Throws Error if `word` cannot be a file name and so must be a misspelt effect; the message suggests the nearest
/// effect or lists all of them.
void RefuseUnknownName(const std::string& word) {
  const std::filesystem::path path(word);
  if (path.has_extension() || path.has_parent_path()) return;
  std::vector<std::string> names;
  for (const EffectInfo* info : Effects()) names.emplace_back(info->name);
  const std::string nearest = FindNearestName(word, names);
  throw Error(fmt::format("\"{}\" is neither an effect nor a scene file; {}", word,
                          nearest.empty() ? fmt::format("the effects are {}", fmt::join(names, ", "))
                                          : fmt::format("the nearest effect is \"{}\"", nearest)));
}

void Run(EffectsArguments& options) {
  if (options.scene.empty()) {
    if (options.measure.all || options.markdown || !options.csv.empty() || options.voxel_mm) {
      throw CLI::ValidationError("SCENE", "is required for a measurement");
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
    CheckInputsNotOverwritten(ListInputs(scene, options.scene), {options.csv});
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
  if (!options.csv.empty()) WriteTextFile(options.csv, FormatStoredCosts(costs));
  fmt::print("{}", options.json       ? FormatEffectCostsJson(costs)
                   : options.markdown ? FormatEffectCostsMarkdown(costs)
                                      : FormatEffectCosts(costs));
}

}  // namespace

void AddEffectsCommand(CLI::App& app) {
  const auto options = std::make_shared<EffectsArguments>();
  CLI::App* command = app.add_subcommand(
      "effects",
      "List the effects that a scene may name; with a scene, which of them are on, why, and the cost of each");
  command->add_option("SCENE", options->scene,
                      "Scene file: its cut is timed alternately with and without each effect; or the name of an "
                      "effect, to list only that one");
  AddNumber(*command, "--seconds", options->measure, "seconds")->capture_default_str();
  AddNumber(*command, "--passes", options->measure, "passes")->capture_default_str();
  command->add_flag("--run", options->as_run,
                    "Move the tool along its path, as 'kerf run' does, instead of with a hand");
  command->add_flag("--all", options->measure.all,
                    "Measure all effects; those that the scene does not name use their defaults");
  command->add_flag("--together", options->measure.together_only,
                    "Measure only all effects together, not each one separately");
  AddNumberOption(*command, "--voxel", options->voxel_mm, "voxel_mm", kVoxelRange_mm,
                  "voxel size, instead of the scene's");
  CLI::Option* core =
      AddNumber(*command, "--core", options->measure, "core", "core that runs the ticks, zero-based; default: any");
  command->add_flag("--realtime", options->measure.realtime, "Use real-time priority (SCHED_FIFO), as the loop does")
      ->needs(core);
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: a table of docs/benchmarks.md")
      ->excludes(json);
  command->add_option("--csv", options->csv, "Also write the costs to this file (volumes/effect_costs.csv)");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
