// kerf tune: the settings for a scene on this machine, written into it.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "experiment/study/tune.h"
#include "kerf/error.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string scene;
  std::string output;
  bool in_place = false;
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

/// A name for the backup that no file has.
std::string BackupFile(const std::string& scene) {
  std::string name = scene + ".bak";
  for (int i = 1; std::filesystem::exists(std::filesystem::symlink_status(name)); ++i) {
    name = fmt::format("{}.bak.{}", scene, i);
  }
  return name;
}

/// Before all the measuring: whether what is to be written can be.
void CheckOutputs(const Options& options, const std::string& target) {
  const std::string evidence = EvidenceFile(target);
  CheckInputsStay({options.scene}, {evidence});
  if (!options.in_place && IsSameFile(options.scene, target)) {
    throw Error(fmt::format("{}: -o names the scene itself; give --in-place to change it, with a backup", target));
  }
  // Made for a moment, and nothing is left of them: permissions, a read-only file system and long names all show.
  const GrowingFile scene_file(target);
  const GrowingFile evidence_file(evidence);
  std::optional<GrowingFile> backup_file;
  if (options.in_place) backup_file.emplace(BackupFile(options.scene));
}

/// Scene, evidence and, in place, the scene as it was; all of them are on the disk before the first gets its name. What
/// was written, for people.
std::string WriteAll(const Options& options, const std::string& target, const std::string& text,
                     const std::string& edited, const std::string& json) {
  const bool changes = !options.in_place || edited != text;
  if (options.in_place && ReadTextFile(options.scene) != text) {
    throw Error(fmt::format("{}: was changed while it was measured; nothing was written", options.scene));
  }
  const std::string backup = options.in_place && changes ? BackupFile(options.scene) : "";
  std::optional<GrowingFile> backup_file;
  if (!backup.empty()) backup_file.emplace(backup).Append(text);
  GrowingFile evidence_file(EvidenceFile(target));
  evidence_file.Append(json);
  std::optional<GrowingFile> scene_file;
  if (changes) scene_file.emplace(target).Append(edited);
  if (backup_file) {
    backup_file->Commit();
    std::error_code ignored;
    std::filesystem::permissions(backup, std::filesystem::status(options.scene, ignored).permissions(), ignored);
  }
  evidence_file.Commit();
  if (scene_file) scene_file->Commit();
  return (changes ? target + " " : "") + EvidenceFile(target) +
         (backup.empty() ? "" : fmt::format("\n  backup    {}, the scene as it was", backup));
}

void PrintChoice(std::FILE* file, const std::string& note, const std::vector<SceneEdit>& edits) {
  fmt::print(file, "  chosen    {}\n", note);
  for (const SceneEdit& edit : edits) fmt::print(file, "            [{}] {} = {}\n", edit.table, edit.key, edit.value);
  if (edits.empty()) fmt::print(file, "            the scene has these settings already\n");
}

/// Whether the scene is written so that settings can be put into it. Throws Error.
void CheckEditable(const std::string& text, const Scene& scene, const Options& options) {
  StudySettings other = SettingsOf(scene, options.tune.holding);
  other.rim_samples_per_pitch = other.rim_samples_per_pitch == 2 ? 4 : 2;
  other.substeps = other.carve_interval_ticks = other.substeps == 3 ? 5 : 3;
  EditScene(text, options.scene, EditsFor(scene, options.tune.holding, other), "");
}

void Run(Options& options) {
  options.tune.budget_us = options.budget_us;
  if (!options.error.empty()) options.tune.error = ParseError(options.error);
  if (!options.tune.budget_us && !options.tune.error) {
    throw CLI::ValidationError("--budget-us", "give --budget-us, --error, or both");
  }
  options.tune.holding = options.led ? Holding::kPath : Holding::kHand;
  if (options.core >= 0) options.tune.core = options.core;
  const std::string target = options.in_place ? options.scene : options.output;  // empty: stdout
  const std::string text = ReadTextFile(options.scene);
  const Scene scene = ParseScene(text, options.scene);
  if (!options.dry_run && !target.empty()) CheckOutputs(options, target);
  CheckEditable(text, scene, options);  // before all the measuring
  options.tune.stop = &CatchInterrupt();
  TuneResult result;
  {
    StageBars bars;
    options.tune.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    result = Tune(options.scene, options.tune);
  }
  for (const std::string& note : result.notes) Say("note: {}", note);
  std::vector<SceneEdit> edits;
  if (result.keeps) edits = EditsFor(scene, options.tune.holding, result.again->settings);
  const std::string json = FormatTuneJson(result, options.tune, edits);
  // Where stdout is the scene's, what was measured is a message.
  const bool scene_to_stdout = target.empty() && !options.dry_run && !options.json;
  std::FILE* table = scene_to_stdout ? stderr : stdout;
  if (options.json) {
    fmt::print("{}", json);
  } else {
    fmt::print(table, "{}\n{}", scene.title.empty() ? scene.name : scene.title, FormatTuneTable(result));
  }
  if (!result.keeps) {
    throw Error(fmt::format("{}: {}; the scene is as it was", options.scene,
                            !result.chosen ? "no setting that was tried keeps what was asked"
                                           : "no setting kept what was asked when it was measured again"));
  }
  const std::string note = DescribeEvidence(result, options.tune);
  if (!options.json) PrintChoice(table, note, edits);
  if (options.dry_run || (options.json && target.empty())) return;
  const std::string edited = edits.empty() ? text : EditScene(text, options.scene, edits, note);
  if (target.empty()) {
    fmt::print("{}", edited);
    return;
  }
  const std::string written = WriteAll(options, target, text, edited, json);
  if (!options.json) fmt::print("  written   {}\n", written);
}

}  // namespace

void AddTuneCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "tune",
      "Measure a scene on this machine with other voxels, samples, steps and removal, and print it with the most "
      "accurate settings within a time, or the cheapest within an error");
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
                   "Measure errors only this long from the first contact on, s, 0.2 to 3600; default: all "
                   "of the path, or the first passage through the bone where that takes more than 120 s")
      ->check(NumberWithin(0.2, 3600, "s"));
  command
      ->add_option("--ticks", options->tune.ticks, "Ticks that each setting is timed over, at least, 1000 to 10000000")
      ->capture_default_str()
      ->check(CLI::Range(1000, 10000000));
  command->add_option("--voxels", options->tune.voxels_mm, "Voxels to try instead of 0.4 to 0.05 mm")
      ->delimiter(',')
      ->check(NumberWithin(0.02, 4, "mm"));
  command->add_option("--core", options->core, "Hold the timed ticks to this core")->check(CLI::Range(0, 4095));
  CLI::Option* output = command->add_option("-o,--output", options->output,
                                            "File for the scene with the settings chosen instead of stdout");
  command
      ->add_flag("--in-place", options->in_place,
                 "Write the settings into SCENE itself; SCENE as it was goes to SCENE.bak, or .bak.1 and so on where "
                 "that is taken")
      ->excludes(output);
  command->add_flag("--dry-run", options->dry_run, "Measure and say what would be chosen; write nothing");
  command->add_flag("--json", options->json, "Print all that was measured as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
