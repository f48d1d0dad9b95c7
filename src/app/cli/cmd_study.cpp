// kerf study: measures how much computing time accuracy costs.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "experiment/study/engine.h"
#include "experiment/study/merge.h"
#include "experiment/study/settings.h"
#include "experiment/study/study_report.h"
#include "kerf/error.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

struct StudyArguments {
  std::vector<std::string> inputs;  // the study file; with --merge, the folders of shards
  std::string folder = "out/study";
  std::string data = "../shared/data";
  std::string shard;
  StudyRunOptions run;
  bool merge = false;
  bool redraw = false;
  bool defaults = false;
  bool dry_run = false;
  bool errors_only = false;
  bool costs_only = false;
  bool json = false;
};

void PrintWarning(const std::string& what) {
  SayWarning("{}", what);
}

std::string ShowTime(double seconds) {
  if (seconds < 90) return fmt::format("{:.0f} s", seconds);
  if (seconds < 5400) return fmt::format("{:.0f} min", seconds / 60);
  return fmt::format("{:.1f} h", seconds / 3600);
}

void DrawReport(const StudyResults& results, const std::string& folder) {
  StageBars bars;
  WriteStudyReport(results, folder, [&](const std::string& what) { bars.Show(what, 0); });
}

void PrintCases(const char* title, const std::vector<std::pair<std::string, std::string>>& cases) {
  if (cases.empty()) return;
  fmt::print("  {}\n", title);
  for (const auto& [name, why] : cases) fmt::print("    {}: {}\n", name, why);
}

/// Writes the report on all records in the folder. Throws Error if any case failed or is missing.
void Finish(const StudyArguments& options, const StudyWork& work, const std::vector<std::string>& missing) {
  const StudyResults results = CollectResults(StudyFolder(options.folder), work.variant_of, PrintWarning);
  DrawReport(results, options.folder);
  std::vector<std::pair<std::string, std::string>> failed;
  std::vector<std::pair<std::string, std::string>> omitted;
  for (const CaseRecord& c : results.cases) {
    if (c.state == CaseState::kFailed) failed.emplace_back(c.id, c.why);
    if (c.state == CaseState::kOmitted) omitted.emplace_back(c.id, c.why);
  }
  if (options.json) {
    nlohmann::ordered_json json{{"schema", 1},
                                {"study", results.name},
                                {"cases", results.cases.size()},
                                {"references", results.references.size()},
                                {"seconds", results.seconds}};
    for (const auto& [key, cases] : {std::pair("failed", &failed), std::pair("omitted", &omitted)}) {
      json[key] = nlohmann::ordered_json::array();
      for (const auto& [id, why] : *cases) json[key].push_back({{"id", id}, {"why", why}});
    }
    json["missing"] = missing;
    fmt::print("{}\n", json.dump(1));
  } else {
    fmt::print("{}\n", results.title.empty() ? results.name : results.title);
    fmt::print("  cases     {}, of which {} failed, {} omitted; {} references; {} of work\n", results.cases.size(),
               failed.size(), omitted.size(), results.references.size(), ShowTime(results.seconds));
    PrintCases("failed", failed);
    PrintCases("omitted", omitted);
    fmt::print("  results   {}/\n", options.folder);
  }
  for (const std::string& sentence : missing) Say("{}", sentence);
  if (!missing.empty()) throw Error(fmt::format("{}: the study is incomplete", options.folder));
  if (!failed.empty()) {
    throw Error(
        fmt::format("{} of {} cases failed; run the same command to retry them", failed.size(), results.cases.size()));
  }
}

void PrintPlan(const StudyArguments& options, const StudyPlan& plan) {
  std::vector<std::size_t> own;
  if (options.run.shard) {
    own = SplitPlan(plan, options.run.shard->count)[static_cast<std::size_t>(options.run.shard->index)];
  } else {
    for (std::size_t i = 0; i < plan.cases.size(); ++i) own.push_back(i);
  }
  const StudyEstimate estimate = EstimateStudy(plan, options.run);
  const double all_s = estimate.references_s + estimate.errors_s + estimate.costs_s;
  if (options.json) {
    nlohmann::ordered_json json{{"schema", 1},
                                {"plan_hash", ShowHash(plan.hash)},
                                {"cases", nlohmann::ordered_json::array()},
                                {"references", estimate.references},
                                {"left", estimate.left},
                                {"references_s", estimate.references_s},
                                {"errors_s", estimate.errors_s},
                                {"costs_s", estimate.costs_s},
                                {"measured", estimate.measured}};
    for (const std::size_t i : own) json["cases"].push_back(plan.cases[i].id);
    fmt::print("{}\n", json.dump(1));
    return;
  }
  for (const std::size_t i : own) fmt::print("{}{}\n", plan.cases[i].id, plan.cases[i].costs ? "" : "  (errors only)");
  fmt::print("{} cases, {} references; {} records to compute\n", estimate.cases, estimate.references, estimate.left);
  fmt::print("about {} on one core: references {}, errors {}, costs {}; {}\n", ShowTime(all_s),
             ShowTime(estimate.references_s), ShowTime(estimate.errors_s), ShowTime(estimate.costs_s),
             estimate.measured ? "estimated from existing records" : "estimated from times on another machine");
}

void Work(StudyArguments& options, const StudyWork& work) {
  const StudySpec spec = options.inputs.empty()
                             ? ParseStudy(DefaultStudyToml(), "the default study", NamesOfStudyPaths())
                             : ReadStudyFile(options.inputs.front(), NamesOfStudyPaths());
  options.run.folder = options.folder;
  options.run.errors = !options.costs_only;
  options.run.costs = !options.errors_only;
  if (options.dry_run) return PrintPlan(options, MakePlan(spec, work.variant_of));
  if (!options.run.shard) RequirePictures();
  options.run.command = fmt::format("kerf study {}", std::filesystem::path(options.inputs.front()).filename().string());
  options.run.stop = &CatchInterrupt();
  options.run.warn = PrintWarning;
  StudyRunOutcome outcome;
  {
    StageBars bars;
    options.run.progress = [&](const std::string& stage, double fraction) { bars.Show(stage, fraction); };
    outcome = RunStudy(spec, work, options.run);
  }
  if (outcome.stopped) {
    const std::size_t records = outcome.kept + outcome.made;
    if (records == 0) throw Error("stopped before any case was completed");
    throw Error(fmt::format("stopped; {} records are kept in {}; the same study with this folder as output continues",
                            records, options.folder));
  }
  if (!options.run.shard) return Finish(options, work, {});
  // A shard has no report of its own; --merge writes the report on the whole study.
  const std::string folder = FolderOfShard(options.folder, *options.run.shard);
  if (options.json) {
    fmt::print("{}\n", nlohmann::ordered_json{{"schema", 1},
                                              {"shard", ToString(*options.run.shard)},
                                              {"kept", outcome.kept},
                                              {"made", outcome.made},
                                              {"failed", outcome.failed.size()},
                                              {"omitted", outcome.omitted.size()}}
                           .dump(1));
  } else {
    fmt::print("shard {}: {} records made, {} kept, {} failed, {} omitted; in {}\n", ToString(*options.run.shard),
               outcome.made, outcome.kept, outcome.failed.size(), outcome.omitted.size(), folder);
    PrintCases("failed", outcome.failed);
  }
  if (!outcome.failed.empty()) {
    throw Error(fmt::format("{} cases failed; run the same command to retry them", outcome.failed.size()));
  }
}

void Run(StudyArguments& options) {
  const int kinds = (options.merge ? 1 : 0) + (options.redraw ? 1 : 0) + (options.defaults ? 1 : 0);
  if (kinds > 1) throw CLI::ValidationError("study", "give only one of --merge, --redraw and --defaults");
  if (kinds > 0 && (options.dry_run || options.run.extend || options.errors_only || options.costs_only)) {
    throw CLI::ValidationError(options.merge    ? "--merge"
                               : options.redraw ? "--redraw"
                                                : "--defaults",
                               "can't be combined with --dry-run, --extend, --errors-only or --costs-only");
  }
  if (options.defaults) {
    const std::string text = DefaultStudyToml();
    std::fwrite(text.data(), 1, text.size(), stdout);
    return;
  }
  if (options.redraw) {
    if (!options.inputs.empty()) throw CLI::ValidationError("--redraw", "takes no STUDY: it reads the results in -o");
    return DrawReport(ReadStudyResults(options.folder), options.folder);
  }
  for (const std::string& input : options.merge ? options.inputs : std::vector<std::string>{}) {
    if (std::filesystem::is_directory(input)) continue;
    throw CLI::ValidationError(
        "--merge", fmt::format("{} is not a folder; give the folders of the shards, or none to merge those in -o: "
                               "kerf study --merge -o {}",
                               input, options.folder));
  }
  const StudyWork work = MakeStudyWork(options.data, (std::filesystem::path(options.folder) / "bones").string());
  if (options.merge) {
    const MergeOutcome outcome = MergeShards(options.inputs, options.folder, work.variant_of, PrintWarning);
    if (!options.json) {
      fmt::print("{} shards, {} records; {} duplicates ignored\n", outcome.shards, outcome.records, outcome.twice);
    }
    return Finish(options, work, outcome.missing);
  }
  // The default study can be planned without its file, but running it takes hours, so a run requires the file.
  if (options.inputs.size() != 1 && !(options.inputs.empty() && options.dry_run)) {
    throw CLI::ValidationError("STUDY",
                               options.inputs.empty() ? "is missing: give one study file" : "give one study file");
  }
  if (!options.shard.empty()) {
    try {
      options.run.shard = ShardFromText(options.shard);
    } catch (const Error& e) {
      throw CLI::ValidationError("--shard", e.what());
    }
  }
  Work(options, work);
}

}  // namespace

void AddStudyCommand(CLI::App& app) {
  const auto options = std::make_shared<StudyArguments>();
  CLI::App* command = app.add_subcommand(
      "study",
      "Measure how much computing time accuracy costs: errors relative to a reference, and times, for many settings "
      "and paths");
  command->add_option("STUDY", options->inputs,
                      "Study file (TOML); with --merge: folders of shards (default: those in -o)");
  command
      ->add_option("-o,--output", options->folder,
                   "Folder for records and report; created if missing; existing records are kept")
      ->capture_default_str();
  command->add_flag("--defaults", options->defaults, "Print the default study as commented TOML");
  command->add_flag("--dry-run", options->dry_run,
                    "Only list the cases and estimate the time; without STUDY, those of the default study");
  CLI::Option* shard =
      command->add_option("--shard", options->shard,
                          "Part of the study to run, I/N: part I of N, zero-based; results in OUTPUT/shard-I-of-N");
  command->add_flag("--merge", options->merge, "Merge shards, and report missing ones")->excludes(shard);
  command->add_flag("--redraw", options->redraw, "Only write the report again from the results in -o");
  AddNumber(*command, "--jobs", options->run, "jobs")->capture_default_str();
  CLI::Option* errors_only =
      command->add_flag("--errors-only", options->errors_only, "Compute errors, but measure no costs");
  command->add_flag("--costs-only", options->costs_only, "Measure costs, but compute no errors")->excludes(errors_only);
  AddNumber(*command, "--core", options->run, "core", "core that runs the ticks, zero-based; default: the last");
  command->add_flag("--extend", options->run.extend,
                    "Allow the folder of another study, and reuse those of its records that fit this one");
  command->add_option("--data", options->data, "Folder with the CT of the path \"ct\"")->capture_default_str();
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
