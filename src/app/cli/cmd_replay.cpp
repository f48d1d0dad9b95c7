#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/exit_codes.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "kerf/error.h"
#include "session/run/run_loop.h"
#include "session/run/run_scene.h"
#include "session/run/run_slab_scene.h"
#include "session/run/session_recorder.h"

namespace kerf::cli {
namespace {

struct ReplayArguments {
  std::string file;
  std::string folder;
  std::string bone_file;
  std::optional<double> until_s;
  double speed = 0;
  bool verify = false;
  bool full = false;
  bool json = false;
};

void PrintHeader(const RecordingReader& recording) {
  const RecordingHeader& header = recording.header();
  fmt::print("{}\n", header.scene_name);
  fmt::print("  recorded  {} by kerf {} ({}) on {}\n", header.created, header.version, header.commit, header.machine);
  if (!header.taken_up_from.empty()) fmt::print("            resumed from {}\n", header.taken_up_from);
  fmt::print("  holds     {:.3f} s, {} ticks, {:.1f} kB\n", recording.duration_s(), recording.steps(),
             1e-3 * static_cast<double>(recording.file_bytes()));
  for (const std::string& warning : FindDamageWarnings(recording)) fmt::print("  damage    {}\n", warning);
  fmt::print("  seal      {}\n", DescribeSeal(recording.seal(), ListOwnKeys()));
}

std::string FormatJson(const RecordingReader& recording, const Replayed& replayed) {
  const RecordingHeader& header = recording.header();
  const std::optional<RecordingEnd>& end = recording.end();
  nlohmann::ordered_json json{{"recording", recording.path()},
                              {"kind", ToString(header.kind)},
                              {"scene", header.scene_name},
                              {"version", header.version},
                              {"commit", header.commit},
                              {"machine", header.machine},
                              {"created", header.created},
                              {"duration_s", recording.duration_s()},
                              {"ticks", recording.steps()},
                              {"bytes", recording.file_bytes()},
                              {"whole", recording.DescribeDamage().empty()},
                              {"state", ToString(recording.damage().state)},
                              {"damage", recording.DescribeDamage()},
                              {"lost_ticks", recording.damage().lost_steps},
                              {"replayed_ticks", replayed.steps},
                              {"replayed_s", replayed.time_s},
                              {"identical", !replayed.divergence},
                              {"force_hash", fmt::format("{:016x}", replayed.force_hash)},
                              {"voxel_hash", fmt::format("{:016x}", replayed.voxel_hash)},
                              {"bone_hash", fmt::format("{:016x}", replayed.bone_hash)}};
  if (end && end->bone_hash) json["recorded_bone_hash"] = fmt::format("{:016x}", *end->bone_hash);
  if (replayed.divergence) {
    json["divergence"] = {{"tick", replayed.divergence->step + 1},
                          {"time_s", replayed.divergence->time_s},
                          {"what", replayed.divergence->what}};
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// Returns the maximum error of the surfaces to be written; 0: not reduced.
double ErrorOf(const ReplayArguments& options) {
  return options.full ? 0 : kSurfaceErrorMm;
}

Replayed ReplayLoop(const ReplayArguments& options, RecordingReader& recording, const RecordedScene& recorded) {
  const Scene& scene = recorded.scene;
  LoopOptions loop;
  loop.virtual_time = true;
  loop.seconds = std::clamp(std::min(options.until_s.value_or(1e9), recording.damage().whole_s), 0.01, kMaxLoop_s);
  loop.stop = &CatchInterrupt();
  loop.output.scene_file = recording.header().scene_file;
  loop.replay.recording = &recording;
  loop.replay.until_s = options.until_s.value_or(std::numeric_limits<double>::infinity());
  loop.replay.verify = options.verify;
  loop.replay.speed = options.speed;
  loop.output.keep_bones = !options.folder.empty();
  loop.output.log = options.folder.empty() ? LoopLog::kNone : LoopLog::kFolder;
  loop.output.folder = options.folder;
  if (!options.folder.empty()) {
    CheckLoopInputsNotOverwritten(scene, options.file, options.folder);
  }
  RunBar bar(ListLoopStages(scene, loop, !options.folder.empty()));
  const auto show = [&](const std::string& now, double fraction) { bar.Show(now, fraction); };
  LoopSummary summary = RunLoop(scene, loop, show);
  const std::vector<std::string> damage = FindDamageWarnings(recording);
  summary.warnings.insert(summary.warnings.begin(), damage.begin(), damage.end());
  if (!options.folder.empty()) WriteLoopReport(scene, summary, options.folder, show, ErrorOf(options));
  return *summary.replayed;
}

Replayed ReplayRun(const ReplayArguments& options, RecordingReader& recording, const RecordedScene& recorded) {
  RunReplay replay(recording, options.until_s.value_or(std::numeric_limits<double>::infinity()), options.verify);
  RunBar bar(ListRunStages(recorded.scene, !options.folder.empty()));
  const auto show = [&](const std::string& now, double fraction) { bar.Show(now, fraction); };
  if (options.folder.empty()) return ReplayScene(recorded.scene, replay, show);
  CheckInputsNotOverwritten(recorded.scene, options.file, options.folder);
  if (recording.header().kind == RecordedKind::kSlab) {
    RunSlabScene(recorded.scene, options.folder, show, {"", "", &replay}, ErrorOf(options));
    return replay.MakeReport(recording.end() ? recording.end()->bone_hash.value_or(0) : 0);
  }
  const RunSummary summary = RunScene(recorded.scene, options.folder, show, {}, {"", "", &replay}, ErrorOf(options));
  return replay.MakeReport(summary.hash_after);
}

void Run(const ReplayArguments& options) {
  if (options.until_s && std::isnan(*options.until_s)) throw CLI::ValidationError("--until", "is not a number");
  RecordingReader recording(options.file);
  if (options.until_s && *options.until_s > recording.duration_s() + 1e-9) {
    throw Error(fmt::format("{}: is {:.3f} s long; {:g} s is after its end", options.file, recording.duration_s(),
                            *options.until_s));
  }
  const RecordingDamage& damage = recording.damage();
  if (options.until_s && *options.until_s > damage.whole_s + 1e-9) {
    throw Error(
        fmt::format("{}: {}; it can be replayed up to {:.3f} s", options.file, damage.sentence, damage.whole_s));
  }
  const RecordedScene recorded = OpenRecordedScene(recording, options.bone_file);
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) lock.emplace(options.folder);
  for (const std::string& warning : FindDamageWarnings(recording)) SayWarning("{}: {}", options.file, warning);
  const bool loop = recording.header().kind == RecordedKind::kLoop;
  if (!loop && options.speed > 0) {
    throw CLI::ValidationError("--speed", "applies to a recorded loop only; a run along a path is not in real time");
  }
  const Replayed replayed = loop ? ReplayLoop(options, recording, recorded) : ReplayRun(options, recording, recorded);
  if (!options.json) PrintHeader(recording);
  if (options.json) fmt::print("{}", FormatJson(recording, replayed));
  if (const std::optional<Divergence>& d = replayed.divergence) {
    const std::string what = fmt::format("{}: differs from the recording from tick {} on, at {:.3f} s: {}",
                                         options.file, d->step + 1, d->time_s, d->what);
    if (options.verify) throw Error(what);
    SayWarning("{}", what);
  } else if (!options.json) {
    fmt::print("  replayed  {:.3f} s, {} ticks: voxels and forces bit-identical to the recording\n", replayed.time_s,
               replayed.steps);
  }
  if (!options.json) {
    fmt::print("  state     bone {:016x}, voxels {:016x}, force {:016x}\n", replayed.bone_hash, replayed.voxel_hash,
               replayed.force_hash);
    if (!options.folder.empty()) fmt::print("  results   {}/\n", options.folder);
  }
  if (damage.state != RecordingState::kWhole) throw ReadDamaged();
}

}  // namespace

void AddReplayCommand(CLI::App& app) {
  const auto options = std::make_shared<ReplayArguments>();
  CLI::App* command =
      app.add_subcommand("replay",
                         "Run a recording again, and report whether voxels and forces are bit-identical. Exit code 3: "
                         "the readable part is identical, but the recording is damaged or cut short");
  command->add_option("FILE", options->file, "Recording (made by --record)")->required();
  command->add_flag("--verify", options->verify,
                    "Stop at the first tick whose forces, voxels, states or events differ, report it, and exit with 1; "
                    "default: warn and continue");
  AddNumberOption(*command, "--speed", options->speed, "speed", Range{0, 1e6},
                  "speed relative to real time; 0: as fast as possible")
      ->capture_default_str();
  AddNumberOption(*command, "--until", options->until_s, "until_s", kSessionTimeRange_s, "time at which to stop");
  command->add_option("-o,--output", options->folder, "Folder for the results of the recorded run; created if missing");
  command->add_flag(
      "--full", options->full,
      fmt::format("Write the pieces at full resolution; otherwise within {:g} mm of it, with fewer triangles",
                  kSurfaceErrorMm));
  command->add_option("--bone", options->bone_file, "Bone file of the recording, if it was moved (.vdb)");
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
