#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/device_option.h"
#include "app/cli/message.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "cut/force/measured.h"
#include "kerf/error.h"
#include "session/run/expected_files.h"
#include "session/run/run_loop.h"
#include "session/run/session_recorder.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string scene;
  std::string folder;
  std::string hand;
  std::optional<double> rate_hz;
  std::string from;
  std::optional<double> at_s;
  std::string bone_file;
  std::vector<std::string> actions;
  bool records = false;
  DeviceOption device;
  LoopOptions loop;
  bool json = false;
  bool full = false;
};

void PrintTimes(const LoopTimeSummary& t) {
  fmt::print("  {:<9} p50 {:>7.1f}  p99 {:>7.1f}  p99.9 {:>7.1f}  max {:>8.1f} us{}\n", t.name, t.p50_us, t.p99_us,
             t.p999_us, t.max_us,
             t.name == "tick" || t.name == "lateness" ? "" : fmt::format("  in {} ticks", t.count));
}

void PrintSummary(const Scene& scene, const LoopSummary& s) {
  fmt::print("{}\n", scene.title.empty() ? scene.name : scene.title);
  fmt::print("  loop      {:.2f} s {} at {:g} Hz: {} ticks, {} missed (at most {} in a row)\n", s.simulated_s,
             s.virtual_time ? "without the clock" : "live", s.rate_hz, s.counts.ticks, s.counts.missed,
             s.counts.longest_gap);
  if (!s.virtual_time) {
    fmt::print("  system    {} {}\n", s.grants.scheduling, s.grants.memory);
    PrintTimes(s.tick);
    PrintTimes(s.lateness);
    for (const LoopTimeSummary& stage : s.stages) {
      if (!s.costs || stage.name == "exchange") PrintTimes(stage);
    }
    if (s.costs) fmt::print("{}", FormatCostTable(*s.costs));
  }
  fmt::print("  device    {}: {:.3g} N on the device for 1 N in the simulation\n", DescribeHeld(s), s.force.scale);
  if (!s.served.empty()) fmt::print("  served    {}\n", DescribeServed(s));
  fmt::print("  coupling  {}\n            {}\n", DescribeCoupling(s.setup), DescribeLimits(s.setup));
  fmt::print(
      "  force     up to {:.2f} N on the device ({:.2f} N simulated); steps up to {:.4f} N a tick, limit {:.4g}\n",
      s.force.largest_N, s.force.largest_simulated_N, s.force.largest_step_N, s.force.slew_bound_N);
  fmt::print("            {}: {}\n            {}\n", scene.force.name(), DescribeAccuracy(scene.force, MakeTool(scene)),
             DescribeBlades(scene.force));
  if (s.cutting) fmt::print("  cutting   {}\n", DescribeCuttingEnergy(*s.cutting));
  fmt::print("  noise     force on the device above 20 Hz: {}\n", DescribeNoise(s));
  fmt::print("  faults    {} not finite, {} bad poses, {} ticks limited or faulty, {} watchdog trips, {} ramps\n",
             s.counts.not_finite + s.device_counts.not_finite, s.counts.bad_poses, s.counts.status_ticks,
             s.watchdog_trips, s.counts.ramps);
  for (const FidelityStep& step : s.fidelity_steps) {
    fmt::print(
        "  fidelity  at {:.2f} s from {} to {}: {}\n", step.time_s, kerf::ToString(step.from), kerf::ToString(step.to),
        step.reason == FidelityReason::kOverrun
            ? fmt::format("{:.0f} % of the ticks over budget, up to {:.0f} us", 100 * step.share_over, step.longest_us)
            : std::string("calm"));
  }
  fmt::print("  removed   {}; {}\n", DescribeRemoved(s), DescribeStrokes(s));
  fmt::print("  bone      {}\n", DescribePieces(s));
  fmt::print("  energy    {}\n", DescribeEnergy(s));
  for (const std::string& effect : DescribeEffects(s.effects)) fmt::print("  effect    {}\n", effect);
  if (s.heat) fmt::print("  heat      {}\n", DescribeHeat(*s.heat));
  if (s.fragments) fmt::print("  fragments {}\n", DescribeFragments(*s.fragments));
  fmt::print("  readers   {} leaves sent; a copy made from them is {}\n", s.leaves_sent,
             s.mirror_identical ? "bit-identical" : "NOT the bone");
  if (s.replayed) {
    fmt::print("  gone on   from a recording: {} ticks, {:.3f} s\n", s.replayed->steps, s.replayed->time_s);
  }
  if (s.undone) {
    fmt::print("  undo      back or forward {} times, {} checkpoints kept in {:.2f} MB\n", s.undone->restores,
               s.undone->checkpoints, s.undone->kept_MB);
    if (!s.virtual_time && s.undone->restores > 0) {
      fmt::print("            at most {:.1f} ms from asking to the bone being there\n", s.undone->longest_ms);
    }
  }
  if (s.recorded) {
    fmt::print("  recorded  {}: {} ticks, {:.1f} kB, {:.2f} MB a minute\n", s.recorded->path, s.recorded->steps,
               1e-3 * static_cast<double>(s.recorded->bytes),
               s.simulated_s > 0 ? 60e-6 * static_cast<double>(s.recorded->bytes) / s.simulated_s : 0);
  }
  fmt::print("  state     bone {:016x}, force {:016x}\n", s.bone_hash, s.force_hash);
}

/// The scene of the file, or of the recording to go on from.
Scene OpenScene(Options& options, std::optional<RecordingReader>& recording, RecordedScene& recorded) {
  if (options.from.empty()) {
    if (options.scene.empty()) throw CLI::RequiredError("SCENE or --from");
    return ReadScene(options.scene);
  }
  if (!options.scene.empty()) throw CLI::ValidationError("--from", "has its own scene; give no other");
  recording.emplace(options.from);
  const RecordingHead& head = recording->head();
  if (head.kind != RecordedKind::kLoop) {
    throw Error(fmt::format("{}: is a recording of 'kerf run', which has no hand that could go on", options.from));
  }
  if (options.at_s && std::isnan(*options.at_s)) throw CLI::ValidationError("--at", "is no number");
  const RecordingDamage& damage = recording->damage();
  if (options.at_s && *options.at_s > recording->duration_s() + 1e-9) {
    throw Error(fmt::format("{}: is {:.3f} s long; there is no moment {:g} s in it", options.from,
                            recording->duration_s(), *options.at_s));
  }
  const bool has_gap = damage.whole_steps < damage.known_steps;
  if (has_gap && options.at_s.value_or(damage.whole_s + 1) > damage.whole_s + 1e-9) {
    throw Error(fmt::format("{}: {}; it can be gone on from up to {:.3f} s, with --at", options.from, damage.sentence,
                            damage.whole_s));
  }
  if (!damage.sentence.empty()) SayWarning("{}: {}", options.from, damage.sentence);
  recorded = OpenRecordedScene(*recording, options.bone_file);
  options.scene = head.scene_file;
  options.loop.replay.recording = &*recording;
  options.loop.replay.until_s = options.at_s.value_or(recording->duration_s());
  options.loop.replay.goes_on = true;
  return recorded.scene;
}

/// The device that holds the tool, or moves the hand that does; null when none is really there.
std::shared_ptr<DeviceServo> TakeDevice(Options& options, Scene& scene) {
  CheckDeviceOption(options.device);
  if (options.device.device.empty()) return nullptr;
  options.loop.device = MakePlayedDevice(options.device);
  if (options.loop.device.is_there()) return nullptr;
  if (options.loop.virtual_time) throw CLI::ValidationError("--virtual", "has no time for a real device");
  std::shared_ptr<DeviceServo> servo = OpenServo(options.device, scene, options.loop.stop);
  if (servo->traits().makes_force) {
    options.loop.device = HoldBy(*servo, options.loop.stop, [](const std::string& message) { Say("{}", message); });
    return servo;
  }
  servo->Agree();  // no force comes of it
  options.loop.make_hand = [servo, R_WD = scene.device.orientation](SimulatedDevice& device, const LoopSetup&,
                                                                    const Vec3& p_TC_mm, double) {
    return std::make_unique<DeflectionHand>(device, *servo, R_WD, p_TC_mm);
  };
  return servo;
}

void Run(Options& options) {
  std::optional<RecordingReader> recording;
  RecordedScene recorded;
  Scene scene = OpenScene(options, recording, recorded);
  options.loop.scene_file = options.scene;
  try {
    for (const std::string& text : options.actions) options.loop.actions.push_back(ParseLoopAction(text));
  } catch (const Error& e) {
    throw CLI::ValidationError("--do", e.what());
  }
  std::stable_sort(options.loop.actions.begin(), options.loop.actions.end(),
                   [](const LoopAction& a, const LoopAction& b) { return a.at_s < b.at_s; });
  if (options.records) {
    std::vector<std::string> inputs = ListInputs(scene, options.scene);
    inputs.push_back(options.from);
    CheckInputsStay(inputs, {options.loop.record});
    CheckNewRecording(options.loop.record);
    // Nor may a result take its place.
    if (!options.folder.empty()) CheckLoopInputsStay(scene, options.loop.record, options.folder);
  }
  if (!options.hand.empty()) scene.hand.model = options.hand;
  if (options.rate_hz) scene.loop.rate_hz = *options.rate_hz;
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) {
    CheckLoopInputsStay(scene, options.scene, options.folder);
    lock.emplace(options.folder);  // before the long work
  }
  const std::string lack =
      DescribeLackForLoop(scene, options.loop.seconds * scene.loop.rate_hz, options.folder, options.loop.record);
  if (!lack.empty()) SayWarning("{}", lack);
  const auto note = std::make_shared<std::string>();
  options.loop.costs.live = [note](const std::string& line) { *note = line; };
  options.loop.stop = &CatchInterrupt();
  const std::shared_ptr<DeviceServo> servo = TakeDevice(options, scene);
  options.loop.keep_bones = !options.folder.empty();
  options.loop.log = options.folder.empty() ? LoopLog::kNowhere : LoopLog::kFolder;
  options.loop.folder = options.folder;
  LoopSummary summary;
  {
    StageBars bars;
    bool waited = false;
    const auto show = [&](const std::string& now, double fraction) {
      bars.Show(now, fraction);
      if (servo) FollowServo(*servo, waited);
      if (now == "cutting") bars.SetNote(*note);
    };
    summary = RunLoop(scene, options.loop, show);
    try {
      if (!options.folder.empty())
        WriteLoopReport(scene, summary, options.folder, show, options.full ? 0 : kSurfaceErrorMm);
    } catch (const Error&) {
      // What can't be made again is said first.
      if (summary.recorded && !summary.recorded->failure.empty()) Say("{}", summary.recorded->failure);
      throw;
    }
  }
  for (const std::string& warning : summary.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatLoopJson(scene, summary));
  } else {
    PrintSummary(scene, summary);
    if (!options.folder.empty()) fmt::print("  results   {}/: {}\n", options.folder, fmt::join(summary.files, " "));
  }
  if (summary.replayed && summary.replayed->divergence) {
    const Divergence& d = *summary.replayed->divergence;
    throw Error(fmt::format("{}: other than recorded from tick {} on, at {:.3f} s: {}", options.from, d.step + 1,
                            d.time_s, d.what));
  }
  if (summary.recorded && !summary.recorded->failure.empty()) throw Error(summary.recorded->failure);
  if (summary.end != LoopEnd::kAsked) throw Error(fmt::format("the loop ended by itself: {}", summary.failure));
}

}  // namespace

void AddLoopCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "loop", "Run a scene live in a simulated hand on a simulated device, and tell how the loop kept its time");
  command->add_option("SCENE", options->scene, "The scene file (TOML; see 'kerf scene --defaults')");
  CLI::Option* from = command->add_option("--from", options->from,
                                          "Go on from a recording, in place of a scene: its end, or the moment --at. "
                                          "One that was cut short is gone on from as it is, with a warning");
  command->add_option("--at", options->at_s, "Moment of the recording to go on from, s")
      ->needs(from)
      ->check(CLI::Range(0.0, 1e9));
  command->add_option("--bone", options->bone_file, "The recording's bone, where it is not where it was (.vdb)")
      ->needs(from);
  command
      ->add_option(
          "--do", options->actions,
          "TIME:checkpoint=NAME, TIME:undo[=NAME], TIME:redo or TIME:rpm=SPEED, TIME in s since the session's or the "
          "recording's start: remember the bone as it is then, go back to that, or to the checkpoint before, "
          "and forward again (until something is cut), set the spindle's speed; may be given many times")
      ->allow_extra_args(false);
  command->add_option("--undo-mb", options->loop.undo_MB, "Memory for going back, MB, 0.2 to 1e6; the oldest go first")
      ->capture_default_str()
      ->check(CLI::Range(0.2, 1e6));
  CLI::Option* record =
      command->add_option("--record", options->loop.record,
                          "Record the session into this file, which must not be there yet (see 'kerf replay')");
  command
      ->add_option(
          "--seconds", options->loop.seconds,
          fmt::format("How long, s (after --at, with --from), 0.01 to {:g}; Ctrl-C ends it earlier", kMostLoop_s))
      ->capture_default_str()
      ->check(CLI::Range(0.01, kMostLoop_s));
  command->add_option("--hand", options->hand, "The hand, H0 to H4, instead of the scene's [hand] model")
      ->transform(CLI::IsMember({"H0", "H1", "H2", "H3", "H4"}, CLI::ignore_case));
  AddDeviceOption(*command, options->device, true);
  CLI::Option* rate = command
                          ->add_option("--rate-hz", options->rate_hz,
                                       "Ticks a second, 250 to 4000, instead of the scene's [loop] rate_hz")
                          ->check(CLI::Range(250.0, 4000.0));
  command->add_option(
      "-o,--output", options->folder,
      "Folder for report, JSON, forces, and as [output] asks bone, pieces and pictures; made when missing; without "
      "it none are written");
  command->add_flag("--full", options->full,
                    fmt::format("Write the pieces at full resolution; else within {:g} mm of it, with fewer triangles",
                                kSurfaceErrorMm));
  CLI::Option* without_clock =
      command->add_flag("--virtual", options->loop.virtual_time,
                        "Without the clock and without threads, as fast as it goes: the same bits each time");
  command
      ->add_option(
          "--burn-us", options->loop.burn_us,
          "Burn so many microseconds in each tick of the middle third (half of it in coarse ticks, a tenth in slab "
          "ticks), to see [loop] degrade work; 0 to 100000")
      ->check(CLI::Range(0.0, 1e5));
  command
      ->add_flag("--costs", options->loop.costs.costs,
                 "Time each effect too, and show what a tick costs: live behind the progress bar, and as a table")
      ->excludes(without_clock);
  command->add_flag("--json", options->json, "Print the summary as JSON");
  rate->excludes(from);
  command->callback([options, record] {
    options->records = record->count() > 0;
    Run(*options);
  });
}

}  // namespace kerf::cli
