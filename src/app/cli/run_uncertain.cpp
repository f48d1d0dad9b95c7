// kerf run --uncertain: the force as a band.
#include "app/cli/run_uncertain.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "experiment/uncertainty/fit_file.h"
#include "experiment/uncertainty/shard_file.h"
#include "experiment/uncertainty/uncertain_files.h"
#include "kerf/error.h"
#include "session/run/run_scene.h"
#include "session/scene/warnings.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

constexpr std::size_t kMaxFitBytes = std::size_t{1} << 24;

struct UncertainArguments {
  UncertainParams params;
  std::string shard;
  std::string fit;
  bool merge = false;
};

std::optional<Shard> ParseShard(const std::string& text) {
  if (text.empty()) return std::nullopt;
  try {
    return ShardFromText(text);
  } catch (const Error& e) {
    throw CLI::ValidationError("--shard", e.what());
  }
}

UncertainRun Compute(const Scene& scene, const UncertainParams& params, const std::optional<Shard>& shard) {
  StageBars bars;
  return RunUncertain(scene, params, shard, [&](const std::string& stage, double done) { bars.Show(stage, done); });
}

/// Writes and prints the results of all samples, or of those that a merge found.
void FinishUncertain(const UncertainRun& run, const Scene& scene, const UncertainRequest& request) {
  const UncertainResult result = CalcUncertainResult(run);
  if (run.head.nominal.peak_N == 0) SayWarning("no tooth cut bone on the path: all forces are 0");
  const std::vector<std::string> files = WriteUncertain(run, result, request.folder, scene.output.pictures);
  if (request.json) {
    fmt::print("{}", FormatUncertainJson(run, result));
  } else {
    fmt::print("{}  results   {}/: {}\n", DescribeUncertain(run, result), request.folder, fmt::join(files, " "));
  }
}

void WriteShard(const Scene& scene, const UncertainArguments& options, Shard shard, const UncertainRequest& request,
                const std::vector<std::string>& inputs) {
  const std::string folder = FolderOfShard(request.folder, shard);
  const std::string file = folder + "/" + kSamplesFile;
  CheckInputsNotOverwritten(inputs, {file});
  const FolderLock lock(folder);
  const UncertainRun run = Compute(scene, options.params, shard);
  WriteTextFile(file, FormatSamples(run, shard));
  if (request.json) {
    fmt::print("{}\n",
               nlohmann::ordered_json{
                   {"schema", 1}, {"shard", ToString(shard)}, {"samples", run.samples.size()}, {"file", file}}
                   .dump(1));
  } else {
    fmt::print("shard {}: {} of {} samples; in {}\n", ToString(shard), run.samples.size(), run.head.samples, file);
  }
}

void RunUncertainCommand(UncertainArguments options, const UncertainRequest& request) {
  const std::optional<Shard> shard = ParseShard(options.shard);
  Scene scene = ReadScene(request.scene);
  if (!options.fit.empty()) {
    options.params.fit = ParseFit(ReadTextFile(options.fit, kMaxFitBytes), options.fit, scene.force,
                                  1000 * CalcTooth(MakeTool(scene)).edge_radius_mm);
  }
  if (request.no_pictures) scene.output.pictures = false;
  for (const std::string& warning : FindWarnings(scene, 0)) SayWarning("{}", warning);
  std::vector<std::string> inputs = ListInputs(scene, request.scene);
  inputs.push_back(options.fit);
  if (shard) return WriteShard(scene, options, *shard, request, inputs);
  if (scene.output.pictures) RequirePictures();
  CheckUncertainInputsNotOverwritten(inputs, request.folder);
  const FolderLock lock(request.folder);
  if (!options.merge) return FinishUncertain(Compute(scene, options.params, shard), scene, request);
  const MergedRun merged = MergeSamples(request.folder, scene, options.params);
  if (!request.json) {
    fmt::print("{} shards, {} samples; {} duplicates ignored\n", merged.files, merged.run.samples.size(), merged.twice);
  }
  const std::string missing = DescribeMissing(merged, request.folder);
  if (!merged.run.samples.empty()) FinishUncertain(merged.run, scene, request);
  if (!missing.empty()) throw Error(missing);
}

}  // namespace

std::function<bool(const UncertainRequest&)> AddUncertainOptions(CLI::App& command,
                                                                 const std::vector<CLI::Option*>& others) {
  const auto options = std::make_shared<UncertainArguments>();
  CLI::Option* uncertain = AddNumber(command, "--uncertain", options->params, "samples");
  uncertain->default_str("");  // without the option there is a single run
  for (CLI::Option* other : others) uncertain->excludes(other);
  AddNumber(command, "--seed", options->params, "seed", "with --uncertain: seed of the drawn values")
      ->capture_default_str()
      ->needs(uncertain);
  AddNumber(command, "--jobs", options->params, "jobs",
            "with --uncertain: number of runs computed at once; 0: one for each core")
      ->capture_default_str()
      ->needs(uncertain);
  CLI::Option* shard =
      command
          .add_option("--shard", options->shard,
                      "With --uncertain: part of the runs to compute, I/N: part I of N, zero-based; results in "
                      "OUTPUT/shard-I-of-N")
          ->needs(uncertain);
  CLI::Option* fit = command
                         .add_option("--fit", options->fit,
                                     "With --uncertain: calibrate.json of the fit that gave the values of [force]; its "
                                     "95 % intervals replace those that the law states")
                         ->needs(uncertain);
  command.add_flag("--merge", options->merge, "With --uncertain: merge the shards in OUTPUT, and report missing ones")
      ->needs(uncertain)
      ->excludes(shard)
      ->excludes(fit);
  return [options, uncertain](const UncertainRequest& request) {
    if (uncertain->count() == 0) return false;
    RunUncertainCommand(*options, request);
    return true;
  };
}

}  // namespace kerf::cli
