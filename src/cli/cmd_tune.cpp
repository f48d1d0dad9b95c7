// kerf tune: the settings for a scene on this machine, written into it.
#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "accuracy/tune.h"
#include "cli/commands.h"
#include "cli/message.h"
#include "cli/numbers.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "files/files.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string scene;
  std::string output;
  std::string error;
  std::optional<double> budget_us;
  TuneOptions tune;
  int core = -1;
  bool led = false;
  bool dry_run = false;
  bool json = false;
};

/// "3.5%" or "0.035".
double ParseError(const std::string& text) {
  const bool percent = !text.empty() && text.back() == '%';
  const std::optional<double> number = ParseNumber(percent ? text.substr(0, text.size() - 1) : text);
  if (!number) throw CLI::ValidationError("--error", fmt::format("'{}' is no share: give 3.5% or 0.035", text));
  const double share = percent ? *number / 100 : *number;
  if (!(share >= 1e-4 && share <= 1)) {
    throw CLI::ValidationError("--error", fmt::format("'{}' is out of range; valid range 0.01% to 100%", text));
  }
  return share;
}

std::string EvidenceFile(const std::string& scene) {
  const std::string ending = ".toml";
  const bool toml = scene.size() > ending.size() && scene.ends_with(ending);
  return (toml ? scene.substr(0, scene.size() - ending.size()) : scene) + ".tune.json";
}

void Run(Options& options) {
  options.tune.budget_us = options.budget_us;
  if (!options.error.empty()) options.tune.error = ParseError(options.error);
  if (!options.tune.budget_us && !options.tune.error) {
    throw CLI::ValidationError("--budget-us", "give --budget-us, --error, or both");
  }
  options.tune.holding = options.led ? Holding::kPath : Holding::kHand;
  if (options.core >= 0) options.tune.core = options.core;
  const std::string target = options.output.empty() ? options.scene : options.output;
  const std::string evidence = EvidenceFile(target);
  const std::string text = ReadTextFile(options.scene);
  const Scene scene = ParseScene(text, options.scene);
  if (!options.dry_run) {
    CheckInputsStay({options.scene}, {evidence});
    CheckWritable(target);
    CheckWritable(evidence);
  }
  // Before all the measuring: whether the scene is written so that settings can be put into it.
  StudySettings other = SettingsOf(scene, options.tune.holding);
  other.rim_samples_per_pitch = other.rim_samples_per_pitch == 2 ? 4 : 2;
  other.substeps = other.carve_interval_ticks = other.substeps == 3 ? 5 : 3;
  EditScene(text, options.scene, EditsFor(scene, options.tune.holding, other), "");
  options.tune.stop = &CatchInterrupt();
  TuneResult result;
  {
    StageBars bars;
    options.tune.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    result = Tune(options.scene, options.tune);
  }
  for (const std::string& note : result.notes) Say("note: {}", note);
  if (options.json) {
    fmt::print("{}", FormatTuneJson(result, options.tune));
  } else {
    fmt::print("{}\n{}", scene.title.empty() ? scene.name : scene.title, FormatTuneTable(result));
  }
  if (!result.chosen || !result.keeps) {
    throw Error(fmt::format("{}: {}; the scene is as it was", options.scene,
                            !result.chosen ? "no setting that was tried keeps what was asked"
                                           : "no setting kept what was asked when it was measured anew"));
  }
  const std::vector<SceneEdit> edits = EditsFor(scene, options.tune.holding, result.again->settings);
  if (!options.json) {
    fmt::print("  chosen    {}\n", DescribeEvidence(result, options.tune));
    for (const SceneEdit& edit : edits) fmt::print("            [{}] {} = {}\n", edit.table, edit.key, edit.value);
    if (edits.empty()) fmt::print("            the scene has these settings already\n");
  }
  if (options.dry_run) return;
  // The scene last: where either can't be written it is as it was.
  const std::string edited = EditScene(text, options.scene, edits, DescribeEvidence(result, options.tune));
  WriteTextFile(evidence, FormatTuneJson(result, options.tune));
  WriteTextFile(target, edited);
  if (!options.json) fmt::print("  written   {} {}\n", target, evidence);
}

}  // namespace

void AddTuneCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "tune",
      "Measure a scene on this machine with other voxels, samples, steps and removal, and write the most accurate "
      "settings within a time, or the cheapest within an error, into it");
  command->add_option("SCENE", options->scene, "The scene file (TOML; see 'kerf scene --defaults')")->required();
  command->add_option("--budget-us", options->budget_us, "Time that 99 % of the ticks must keep, us, 1 to 1000000")
      ->check(NumberWithin(1, 1e6, "us"));
  command->add_option(
      "--error", options->error,
      "Force error that 95 % of the ticks must keep, as 3.5% or 0.035: the cheapest settings are chosen");
  command->add_flag("--led", options->led,
                    "The tool led along the path, as 'kerf run' does; else in a hand, as 'kerf loop'");
  command
      ->add_option("--seconds", options->tune.seconds,
                   "Stretch of the path, from the first contact on, for errors, s, 0.2 to 60")
      ->capture_default_str()
      ->check(NumberWithin(0.2, 60, "s"));
  command
      ->add_option("--ticks", options->tune.ticks, "Ticks that each setting is timed over, at least, 1000 to 10000000")
      ->capture_default_str()
      ->check(CLI::Range(1000, 10000000));
  command->add_option("--voxels", options->tune.voxels_mm, "Voxels to try instead of 0.4 to 0.05 mm")
      ->delimiter(',')
      ->check(NumberWithin(0.02, 4, "mm"));
  command->add_option("--core", options->core, "Hold the timed ticks to this core")->check(CLI::Range(0, 4095));
  command->add_option("-o,--output", options->output, "Write the scene there instead of into SCENE");
  command->add_flag("--dry-run", options->dry_run, "Measure and say what would be chosen; write nothing");
  command->add_flag("--json", options->json, "Print all that was measured as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
