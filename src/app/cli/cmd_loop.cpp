#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/device_option.h"
#include "app/cli/link_option.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "cut/force/measured.h"
#include "cut/tool/looks.h"
#include "kerf/error.h"
#include "session/run/expected_files.h"
#include "session/run/loop_undo.h"
#include "session/run/run_loop.h"
#include "session/run/session_recorder.h"
#include "session/scene/scene.h"
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

struct LoopArguments {
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
  LinkOption link;
  bool json = false;
  bool full = false;
};

void PrintTimes(const PartTimes& t) {
  fmt::print("  {:<9} p50 {:>7.1f}  p99 {:>7.1f}  p99.9 {:>7.1f}  max {:>8.1f} us{}\n", t.name, t.p50_us, t.p99_us,
             t.p999_us, t.max_us,
             t.name == "tick" || t.name == "lateness" ? "" : fmt::format("  in {} ticks", t.count));
}

void PrintSummary(const Scene& scene, const LoopSummary& s) {
  fmt::print("{}\n", scene.TitleOrName());
  fmt::print("  loop      {:.2f} s {} at {:g} Hz: {} ticks, {} missed (at most {} in a row)\n", s.simulated_s,
             s.virtual_time ? "in virtual time" : "live", s.rate_hz, s.counts.ticks, s.counts.missed,
             s.counts.longest_gap);
  if (!s.virtual_time) {
    fmt::print("  system    {} {}\n", s.grants.scheduling, s.grants.memory);
    PrintTimes(s.tick);
    PrintTimes(s.lateness);
    for (const PartTimes& stage : s.stages) {
      if (!s.costs || stage.name == "exchange") PrintTimes(stage);
    }
    if (s.costs) fmt::print("{}", FormatCostTable(*s.costs));
  }
  fmt::print("  device    {}: {:.3g} N on the device for 1 N in the simulation\n", DescribeDeviceAndHand(s),
             s.force.scale);
  if (!s.device_figures.empty()) fmt::print("  driver    {}\n", DescribeDeviceFigures(s));
  fmt::print("  coupling  {}\n            {}\n", DescribeCoupling(s.setup), DescribeLimits(s.setup));
  fmt::print(
      "  force     up to {:.2f} N on the device ({:.2f} N simulated); steps up to {:.4f} N a tick, limit {:.4g}\n",
      s.force.largest_N, s.force.largest_simulated_N, s.force.largest_step_N, s.force.slew_bound_N);
  fmt::print("            {}, {}\n            {}\n            {}\n", scene.force.name(), DescribeBites(scene),
             DescribeAccuracy(scene.force, MakeTool(scene)), DescribeBlades(scene.force, MakeTool(scene)));
  if (s.cutting) fmt::print("  cutting   {}\n", DescribeCuttingEnergy(*s.cutting));
  fmt::print("  noise     force on the device above 20 Hz: {}\n", DescribeNoise(s));
  fmt::print("  faults    {} not finite, {} bad poses, {} ticks limited or faulty, {} watchdog trips, {} ramps\n",
             s.counts.not_finite + s.device_counts.not_finite, s.counts.bad_poses, s.counts.status_ticks,
             s.watchdog_trips, s.counts.ramps);
  for (const FidelityStep& step : s.fidelity_steps) {
    fmt::print(
        "  fidelity  at {:.2f} s from {} to {}: {}\n", step.time_s, kerf::ToString(step.from), kerf::ToString(step.to),
        step.reason == FidelityReason::kOverrun ? fmt::format("{:.0f} % of the ticks over budget, up to {:.0f} us",
                                                              100 * step.fraction_over, step.longest_us)
                                                : std::string("the ticks were within budget"));
  }
  const std::string strokes = DescribeStrokes(s);
  fmt::print("  removed   {}{}{}\n", DescribeRemoved(s), strokes.empty() ? "" : "; ", strokes);
  fmt::print("  bone      {}\n", DescribePieces(s));
  fmt::print("  energy    {}\n", DescribeEnergy(s));
  for (const std::string& effect : DescribeEffects(s.effects)) fmt::print("  effect    {}\n", effect);
  if (s.heat) fmt::print("  heat      {}\n", DescribeHeat(*s.heat));
  if (s.fragments) fmt::print("  fragments {}\n", DescribeFragments(*s.fragments));
  fmt::print("  readers   {} leaves sent; a copy made from them is {}\n", s.leaves_sent,
             s.mirror_identical ? "bit-identical" : "NOT identical");
  if (s.replayed) {
    fmt::print("  resumed   from a recording: {} ticks, {:.3f} s\n", s.replayed->steps, s.replayed->time_s);
  }
  if (s.undo) {
    fmt::print("  undo      undone or redone {} times, {} checkpoints kept in {:.2f} MB\n", s.undo->restores,
               s.undo->checkpoints, s.undo->kept_MB);
    if (!s.virtual_time && s.undo->restores > 0) {
      fmt::print("            at most {:.1f} ms from the request to the restored bone\n", s.undo->longest_ms);
    }
  }
  if (s.recorded) {
    fmt::print("  recorded  {}: {} ticks, {:.1f} kB, {:.2f} MB a minute\n", s.recorded->path, s.recorded->steps,
               1e-3 * static_cast<double>(s.recorded->bytes),
               s.simulated_s > 0 ? 60e-6 * static_cast<double>(s.recorded->bytes) / s.simulated_s : 0);
  }
  fmt::print("  state     bone {:016x}, force {:016x}\n", s.bone_hash, s.force_hash);
}

/// Reads the scene from its file, or from the recording that is to be continued.
Scene OpenScene(LoopArguments& options, std::optional<RecordingReader>& recording, RecordedScene& recorded) {
  if (options.from.empty()) {
    if (options.scene.empty()) throw CLI::RequiredError("SCENE or --from");
    return ReadScene(options.scene);
  }
  if (!options.scene.empty()) throw CLI::ValidationError("--from", "uses the recording's scene; give no other");
  recording.emplace(options.from);
  const RecordingHeader& header = recording->header();
  if (header.kind != RecordedKind::kLoop) {
    throw Error(fmt::format("{}: is a recording of 'kerf run', which can't be resumed", options.from));
  }
  if (options.at_s && std::isnan(*options.at_s)) throw CLI::ValidationError("--at", "is not a number");
  const RecordingDamage& damage = recording->damage();
  if (options.at_s && *options.at_s > recording->duration_s() + 1e-9) {
    throw Error(fmt::format("{}: is {:.3f} s long; {:g} s is after its end", options.from, recording->duration_s(),
                            *options.at_s));
  }
  const bool has_gap = damage.whole_steps < damage.known_steps;
  if (has_gap && options.at_s.value_or(damage.whole_s + 1) > damage.whole_s + 1e-9) {
    throw Error(fmt::format("{}: {}; it can be resumed up to {:.3f} s, with --at", options.from, damage.sentence,
                            damage.whole_s));
  }
  if (!damage.sentence.empty()) SayWarning("{}: {}", options.from, damage.sentence);
  recorded = OpenRecordedScene(*recording, options.bone_file);
  options.scene = header.scene_file;
  options.loop.replay.recording = &*recording;
  options.loop.replay.until_s = options.at_s.value_or(recording->duration_s());
  options.loop.replay.continues = true;
  return recorded.scene;
}

/// Opens the device that holds the tool or moves the hand; null if there is no real device.
std::shared_ptr<DeviceServo> TakeDevice(LoopArguments& options, Scene& scene) {
  CheckDeviceOption(options.device);
  if (options.device.device.empty()) return nullptr;
  options.loop.driver.device = MakePlayedDevice(options.device);
  if (options.loop.driver.device.is_set()) return nullptr;
  if (options.loop.virtual_time) throw CLI::ValidationError("--virtual", "can't be used with a real device");
  std::shared_ptr<DeviceServo> servo = OpenServo(options.device, scene, options.loop.stop);
  if (servo->traits().holds_tool()) {
    options.loop.driver.device =
        MakeLoopDevice(*servo, options.loop.stop, [](const std::string& message) { Say("{}", message); });
    return servo;
  }
  servo->Agree();  // safe: the device outputs no force
  options.loop.driver.make_hand = [servo, R_WD = scene.device.orientation](SimulatedDevice& device, const LoopSetup&,
                                                                           const Vec3& p_TC_mm, double) {
    return std::make_unique<DeflectionHand>(device, *servo, R_WD, p_TC_mm);
  };
  return servo;
}

void Run(LoopArguments& options) {
  std::optional<RecordingReader> recording;
  RecordedScene recorded;
  Scene scene = OpenScene(options, recording, recorded);
  options.loop.output.scene_file = options.scene;
  try {
    for (const std::string& text : options.actions) {
      options.loop.undo.actions.push_back(ParseLoopAction(text, CalcRateRange(MakeTool(scene))));
    }
  } catch (const Error& e) {
    throw CLI::ValidationError("--do", e.what());
  }
  std::stable_sort(options.loop.undo.actions.begin(), options.loop.undo.actions.end(),
                   [](const LoopAction& a, const LoopAction& b) { return a.at_s < b.at_s; });
  if (options.records) {
    std::vector<std::string> inputs = ListInputs(scene, options.scene);
    inputs.push_back(options.from);
    CheckInputsNotOverwritten(inputs, {options.loop.output.record});
    CheckNewRecording(options.loop.output.record);
    // Results must not overwrite the recording.
    if (!options.folder.empty()) CheckLoopInputsNotOverwritten(scene, options.loop.output.record, options.folder);
  }
  // The sections are recorded even if the scene does not have them.
  if (!options.hand.empty()) {
    scene.hand.model = options.hand;
    scene.hand.given = true;
  }
  if (options.rate_hz) {
    scene.loop.rate_hz = *options.rate_hz;
    scene.loop.given = true;
  }
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) {
    CheckLoopInputsNotOverwritten(scene, options.scene, options.folder);
    lock.emplace(options.folder);  // taken before the long computation
  }
  const std::string lack =
      DescribeLackForLoop(scene, options.loop.seconds * scene.loop.rate_hz, options.folder, options.loop.output.record);
  if (!lack.empty()) SayWarning("{}", lack);
  const auto note = std::make_shared<std::string>();
  options.loop.costs.live = [note](const std::string& line) { *note = line; };
  options.loop.stop = &CatchInterrupt();
  const std::shared_ptr<SlicerLink> link = OpenLink(options.link);
  if (link) options.device.tracked_tool = link->tracked_tool();
  const std::shared_ptr<DeviceServo> servo = TakeDevice(options, scene);
  options.loop.output.keep_bones = !options.folder.empty();
  options.loop.output.log = options.folder.empty() ? LoopLog::kNone : LoopLog::kFolder;
  options.loop.output.folder = options.folder;
  if (link) {
    link->Show(scene.TitleOrName(), MakeToolLooks(MakeTool(scene)).whole);
    options.loop.watchers.peer = link.get();
    options.loop.watchers.take_tick = [&link](const LoopTick& tick, std::span<const double> channels) {
      link->TakeTick(tick, channels);
    };
  }
  LoopSummary summary;
  {
    RunBar bar(ListLoopStages(scene, options.loop, !options.folder.empty()));
    bool waited = false;
    const auto show = [&](const std::string& now, double fraction) {
      bar.Show(now, fraction);
      if (servo) FollowServo(*servo, waited);
      if (now == "cutting") {
        bar.SetNote(*note);
      } else if (options.loop.stop->load() && !options.folder.empty()) {
        bar.SetNote("(Ctrl-C: end at once)");
      }
    };
    summary = RunLoop(scene, options.loop, show);
    if (link) link->End("the session has ended");
    try {
      if (!options.folder.empty())
        WriteLoopReport(scene, summary, options.folder, show, options.full ? 0 : kSurfaceErrorMm);
    } catch (const Error&) {
      // Report a lost recording first: the session cannot be repeated.
      if (summary.recorded && !summary.recorded->failure.empty()) Say("{}", summary.recorded->failure);
      throw;
    }
  }
  if (link) SayLinkCounts(*link);
  for (const std::string& warning : summary.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatLoopJson(scene, summary));
  } else {
    PrintSummary(scene, summary);
    if (!options.folder.empty()) fmt::print("  results   {}/: {}\n", options.folder, fmt::join(summary.files, " "));
  }
  if (summary.replayed && summary.replayed->divergence) {
    const Divergence& d = *summary.replayed->divergence;
    throw Error(fmt::format("{}: differs from the recording from tick {} on, at {:.3f} s: {}", options.from, d.step + 1,
                            d.time_s, d.what));
  }
  if (summary.recorded && !summary.recorded->failure.empty()) throw Error(summary.recorded->failure);
  if (summary.end != LoopEnd::kRequested) throw Error(fmt::format("the loop ended early: {}", summary.failure));
}

}  // namespace

void AddLoopCommand(CLI::App& app) {
  const auto options = std::make_shared<LoopArguments>();
  CLI::App* command = app.add_subcommand(
      "loop", "Run a scene in real time with a simulated hand or a haptic device, and report the loop's timing");
  command->add_option("SCENE", options->scene, "Scene file (TOML; see 'kerf scene --defaults')");
  CLI::Option* from = command->add_option("--from", options->from,
                                          "Resume a recording instead of a scene: from its end, or from the time --at. "
                                          "A recording that was cut short is resumed as it is, with a warning");
  AddNumberOption(*command, "--at", options->at_s, "at_s", kSessionTimeRange_s,
                  "time of the recording from which to resume")
      ->needs(from);
  command->add_option("--bone", options->bone_file, "Bone file of the recording, if it was moved (.vdb)")->needs(from);
  command
      ->add_option("--do", options->actions,
                   "Action at a time, s since the start of the session or the recording: TIME:checkpoint=NAME stores "
                   "the bone, TIME:undo[=NAME] restores that or the previous checkpoint, TIME:redo reverts an undo "
                   "(until something is cut), TIME:rpm=SPEED sets the speed of the spindle, or the double strokes a "
                   "minute; may be repeated")
      ->allow_extra_args(false);
  AddNumber(*command, "--undo-mb", options->loop.undo, "max_MB")->capture_default_str();
  CLI::Option* record =
      command->add_option("--record", options->loop.output.record,
                          "Record the session into this file, which must not exist yet (see 'kerf replay')");
  AddNumber(*command, "--seconds", options->loop, "seconds",
            "duration (after --at, with --from); Ctrl-C ends it earlier")
      ->capture_default_str();
  command->add_option("--hand", options->hand, "Hand model, H0 to H4, instead of the scene's [hand] model")
      ->transform(CLI::IsMember({"H0", "H1", "H2", "H3", "H4"}, CLI::ignore_case));
  AddDeviceOption(*command, options->device, true);
  CLI::Option* rate = AddNumberOption(*command, "--rate-hz", options->rate_hz, "rate_hz", kTickRateRange_hz,
                                      "ticks per second; replaces the scene's [loop] rate_hz");
  command->add_option("-o,--output", options->folder,
                      "Folder for report, JSON, forces, and the bone, pieces and pictures that [output] requests; "
                      "created if missing; default: no files are written");
  command->add_flag(
      "--full", options->full,
      fmt::format("Write the pieces at full resolution; otherwise within {:g} mm of it, with fewer triangles",
                  kSurfaceErrorMm));
  CLI::Option* without_clock = command->add_flag(
      "--virtual", options->loop.virtual_time,
      "Run in virtual time and without threads, as fast as possible: the results are bit-identical each time");
  AddNumber(*command, "--burn-us", options->loop, "burn_us");
  AddLinkOption(*command, options->link)->excludes(without_clock);
  command
      ->add_flag("--costs", options->loop.costs.costs,
                 "Time each effect too, and show the cost of a tick: live after the progress bar, and as a table")
      ->excludes(without_clock);
  command->add_flag("--json", options->json, "Print as JSON");
  rate->excludes(from);
  command->callback([options, record] {
    options->records = record->count() > 0;
    Run(*options);
  });
}

}  // namespace kerf::cli
