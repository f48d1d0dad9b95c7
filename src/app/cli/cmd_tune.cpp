// kerf tune: finds the settings for a scene on this machine and writes them into it.
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

struct TuneArguments {
  std::string scene;
  std::string output;
  bool in_place = false;
  std::string error;
  TuneOptions tune;
  bool led = false;
  bool dry_run = false;
  bool json = false;
};

/// Parses a fraction such as "3.5%" or "0.035".
double ParseError(const std::string& text) {
  const bool percent = !text.empty() && text.back() == '%';
  const std::optional<double> number = ParseNumber(percent ? text.substr(0, text.size() - 1) : text);
  if (!number) throw CLI::ValidationError("--error", fmt::format("'{}' is not a fraction: give 3.5% or 0.035", text));
  const double fraction = percent ? *number / 100 : *number;
  const std::string fault = FindRangeFault(100 * fraction, 100 * FindRange<TuneOptions>("error"), "%");
  if (!fault.empty()) throw CLI::ValidationError("--error", fmt::format("{} {}", text, fault));
  return fraction;
}

std::string EvidenceFile(const std::string& scene) {
  const std::string ending = ".toml";
  const bool toml = scene.size() > ending.size() && scene.ends_with(ending);
  return (toml ? scene.substr(0, scene.size() - ending.size()) : scene) + ".tune.json";
}

/// Returns a name for the backup that does not exist yet.
std::string BackupFile(const std::string& scene) {
  std::string name = scene + ".bak";
  for (int i = 1; std::filesystem::exists(std::filesystem::symlink_status(name)); ++i) {
    name = fmt::format("{}.bak.{}", scene, i);
  }
  return name;
}

/// Checks that the outputs can be written. Called before the measurements.
void CheckOutputs(const TuneArguments& options, const std::string& target) {
  const std::string evidence = EvidenceFile(target);
  CheckInputsNotOverwritten({options.scene}, {evidence});
  if (!options.in_place && IsSameFile(options.scene, target)) {
    throw Error(fmt::format("{}: -o is the scene itself; give --in-place to change it, with a backup", target));
  }
  // These files are created temporarily and removed again. This detects missing permissions, a read-only file system
  // and names that are too long.
  const GrowingFile scene_file(target);
  const GrowingFile evidence_file(evidence);
  std::optional<GrowingFile> backup_file;
  if (options.in_place) backup_file.emplace(BackupFile(options.scene));
}

/// Writes the scene, the evidence and, if the scene is edited in place, a backup of it. All files are on the disk
/// before the first one is renamed. Returns a human-readable description of what was written.
std::string WriteAll(const TuneArguments& options, const std::string& target, const std::string& text,
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
         (backup.empty() ? "" : fmt::format("\n  backup    {}, the original scene", backup));
}

void PrintChoice(std::FILE* file, const std::string& note, const std::vector<SceneEdit>& edits) {
  fmt::print(file, "  chosen    {}\n", note);
  for (const SceneEdit& edit : edits) fmt::print(file, "            [{}] {} = {}\n", edit.table, edit.key, edit.value);
  if (edits.empty()) fmt::print(file, "            the scene has these settings already\n");
}

/// Checks that settings can be inserted into the text of the scene. Throws Error.
void CheckEditable(const std::string& text, const Scene& scene, const TuneArguments& options) {
  StudySettings other = SettingsOf(scene, options.tune.holding);
  other.rim_samples_per_pitch = other.rim_samples_per_pitch == 2 ? 4 : 2;
  other.substeps = other.carve_interval_ticks = other.substeps == 3 ? 5 : 3;
  EditScene(text, options.scene, EditsFor(scene, options.tune.holding, other), "");
}

void Run(TuneArguments& options) {
  if (!options.error.empty()) options.tune.error = ParseError(options.error);
  if (!options.tune.budget_us && !options.tune.error) {
    throw CLI::ValidationError("--budget-us", "give --budget-us, --error, or both");
  }
  options.tune.holding = options.led ? Holding::kPath : Holding::kHand;
  const std::string target = options.in_place ? options.scene : options.output;  // empty: stdout
  const std::string text = ReadTextFile(options.scene);
  const Scene scene = ParseScene(text, options.scene);
  if (!options.dry_run && !target.empty()) CheckOutputs(options, target);
  CheckEditable(text, scene, options);  // called before the measurements
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
  // If the scene goes to stdout, the measurements are printed on stderr.
  const bool scene_to_stdout = target.empty() && !options.dry_run && !options.json;
  std::FILE* table = scene_to_stdout ? stderr : stdout;
  if (options.json) {
    fmt::print("{}", json);
  } else {
    fmt::print(table, "{}\n{}", scene.TitleOrName(), FormatTuneTable(result));
  }
  if (!result.keeps) {
    throw Error(fmt::format("{}: {}; the scene is unchanged", options.scene,
                            !result.chosen ? "no tested setting meets the limits"
                                           : "no setting met the limits when it was measured again"));
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
  const auto options = std::make_shared<TuneArguments>();
  CLI::App* command =
      app.add_subcommand("tune",
                         "Measure a scene on this machine with various voxel sizes, samples, substeps and removal "
                         "intervals, and print it with the most accurate settings within a time limit, or the cheapest "
                         "within an error limit");
  command->add_option("SCENE", options->scene, "Scene file (TOML; see 'kerf scene --defaults')")->required();
  AddNumber(*command, "--budget-us", options->tune, "budget_us");
  command->add_option("--error", options->error,
                      "Force error limit for 95 % of the ticks, as 3.5% or 0.035: the cheapest settings are chosen");
  command->add_flag("--led", options->led, "Move the tool along its path, as 'kerf run' does, instead of with a hand");
  AddNumber(*command, "--seconds", options->tune, "seconds");
  AddNumber(*command, "--ticks", options->tune, "ticks")->capture_default_str();
  AddNumber(*command, "--voxels", options->tune, "voxels_mm")->delimiter(',');
  AddNumber(*command, "--core", options->tune, "core", "core that runs the timed ticks, zero-based; default: any");
  CLI::Option* output = command->add_option("-o,--output", options->output,
                                            "File for the scene with the chosen settings; default: stdout");
  command
      ->add_flag(
          "--in-place", options->in_place,
          "Write the settings into SCENE itself; the original is kept as SCENE.bak, or .bak.1 and so on if that exists")
      ->excludes(output);
  command->add_flag("--dry-run", options->dry_run, "Measure and print the choice; write nothing");
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
