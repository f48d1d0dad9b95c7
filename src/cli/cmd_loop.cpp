#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "cli/commands.h"
#include "cli/progress.h"
#include "cli/signals.h"
#include "files/files.h"
#include "kerf/error.h"
#include "scene/scene.h"
#include "session/run_loop.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string scene;
  std::string folder;
  std::string hand;
  std::optional<double> rate_hz;
  LoopOptions loop;
  bool json = false;
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
  fmt::print("  device    {} in the hand {}: {:.3g} N on the device for 1 N in the simulation\n", s.device, s.hand,
             s.force.scale);
  fmt::print("  coupling  {}\n            {}\n", DescribeCoupling(s.setup), DescribeLimits(s.setup));
  fmt::print(
      "  force     up to {:.2f} N on the device ({:.2f} N simulated); steps up to {:.4f} N a tick, limit {:.4g}\n",
      s.force.largest_N, s.force.largest_simulated_N, s.force.largest_step_N, s.force.slew_bound_N);
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
  fmt::print("  state     bone {:016x}, force {:016x}\n", s.bone_hash, s.force_hash);
}

void Run(Options& options) {
  Scene scene = ReadScene(options.scene);
  if (!options.hand.empty()) scene.hand.model = options.hand;
  if (options.rate_hz) scene.loop.rate_hz = *options.rate_hz;
  if (!options.folder.empty()) {
    CheckLoopInputsStay(scene, options.scene, options.folder);
    MakeFolder(options.folder);  // before the long work
  }
  const auto note = std::make_shared<std::string>();
  options.loop.costs.live = [note](const std::string& line) { *note = line; };
  options.loop.stop = &CatchInterrupt();
  options.loop.keep_bones = !options.folder.empty();
  LoopSummary summary;
  {
    StageBars bars;
    const auto show = [&](const std::string& now, double fraction) {
      bars.Show(now, fraction);
      if (now == "cutting") bars.SetNote(*note);
    };
    summary = RunLoop(scene, options.loop, show);
    if (!options.folder.empty()) WriteLoopReport(scene, summary, options.folder, show);
  }
  for (const std::string& warning : summary.warnings) fmt::print(stderr, "kerf: warning: {}\n", warning);
  if (options.json) {
    fmt::print("{}", FormatLoopJson(scene, summary));
  } else {
    PrintSummary(scene, summary);
    if (!options.folder.empty()) fmt::print("  results   {}/: {}\n", options.folder, fmt::join(summary.files, " "));
  }
  if (summary.end != LoopEnd::kAsked) throw Error(fmt::format("the loop ended by itself: {}", summary.failure));
}

}  // namespace

void AddLoopCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "loop", "Run a scene live in a simulated hand on a simulated device, and tell how the loop kept its time");
  command->add_option("SCENE", options->scene, "The scene file (TOML; see 'kerf scene --defaults')")->required();
  command->add_option("--seconds", options->loop.seconds, "How long, s, 0.01 to 3600; Ctrl-C ends it earlier")
      ->capture_default_str()
      ->check(CLI::Range(0.01, 3600.0));
  command->add_option("--hand", options->hand, "The hand, H0 to H4, instead of the scene's [hand] model")
      ->transform(CLI::IsMember({"H0", "H1", "H2", "H3", "H4"}, CLI::ignore_case));
  command
      ->add_option("--rate-hz", options->rate_hz, "Ticks a second, 250 to 4000, instead of the scene's [loop] rate_hz")
      ->check(CLI::Range(250.0, 4000.0));
  command->add_option(
      "-o,--output", options->folder,
      "Folder for report, JSON, forces, and as [output] asks bone, pieces and pictures; made when missing; without "
      "it none are written");
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
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
