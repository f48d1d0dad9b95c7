// kerf stability: whether a scene's bone, tool, device, hand and gains are stable together.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/message.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "device/devices/profiles.h"
#include "experiment/stability_study/stability.h"
#include "experiment/stability_study/stability_files.h"
#include "experiment/stability_study/sweep.h"
#include "kerf/error.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

struct Options {
  std::string scene;
  std::string folder;
  std::string profile;
  std::string hand;
  StabilityOptions study;
  bool profiles = false;
  bool sweeps = false;
  SweepOptions sweep;
  bool json = false;
};

void PrintStudy(const StabilityStudy& s) {
  fmt::print("{}\n", s.title.empty() ? s.scene : s.title);
  fmt::print("  device    {} in the hand {}, {:g} Hz: {:.3g} N on the device for 1 N in the simulation\n",
             s.setup.profile.name, s.setup.hand.name, s.rate_hz, s.setup.force_scale);
  fmt::print("  coupling  {}, damping {:.4g} N s/mm\n            {}\n", DescribeCoupling(s.setup),
             s.setup.fitted.coupling.damping_Ns_per_mm, DescribeLimits(s.setup));
  fmt::print("\n  {:<25} {:<48} {:>9} {:>16}  holds\n", "scenario", "figure nearest to its bound", "measured", "bound");
  for (const ScenarioResult& scenario : s.scenarios) {
    if (scenario.skipped) fmt::print("  {:<25} {}\n", scenario.name, scenario.what);
    // All that does not hold, or what is nearest to it.
    if (!scenario.unjudged.empty()) {
      fmt::print("  {:<25} {}  {}\n", scenario.name, scenario.unjudged, ToString(Judgement::kNotJudged));
    }
    if (scenario.cut_through_s) fmt::print("  {:<25} {}\n", scenario.name, DescribeCutThrough(scenario));
    const StabilityFigure* nearest = scenario.skipped ? nullptr : FindNearest(scenario);
    for (const StabilityFigure& f : scenario.figures) {
      if (f.holds() && (!scenario.holds() || &f != nearest)) continue;
      fmt::print("  {:<25} {:<48} {:>9.3g} {:>16}  {}\n", scenario.name,
                 f.unit.empty() ? f.name : fmt::format("{} ({})", f.name, f.unit), f.value,
                 fmt::format("{} {:.3g}", f.at_most ? "at most" : "at least", f.bound), f.holds() ? "yes" : "NO");
    }
  }
  fmt::print("\n  {:<25} {:<18} {:>16} {:>16}  holds\n", "margin: gain / ticks", "hand", "as it is", "linear");
  for (const HandMargins& m : s.margins) {
    if (!m.done || m.linear) continue;
    for (const HandMargins& linear : s.margins) {
      if (!linear.done || !linear.linear || linear.hand != m.hand || linear.state != m.state) continue;
      const Judgement both = Both(m.judgement(), linear.judgement());
      fmt::print("  {:<25} {:<18} {:>16} {:>16}  {}\n", ToString(m.state), m.own ? m.hand + " (the scene's)" : m.hand,
                 DescribeMargins(m.margins), DescribeMargins(linear.margins),
                 both == Judgement::kBroken ? "NO" : ToString(both));
    }
  }
  fmt::print("\n");
  if (const std::string worst = DescribeWorst(s); !worst.empty()) fmt::print("  worst     {}\n", worst);
  fmt::print("  verdict   {}\n", DescribeVerdict(s));
  for (const std::string& finding : s.findings) fmt::print("            {}\n", finding);
}

/// A bar for each stage, shown by whichever thread comes.
class Bars {
 public:
  void Show(const std::string& now, double fraction) {
    // One bar for the whole list of work: its stages run beside each other.
    const std::string title = now == "making the bone" ? now : "examining the loop";
    if (title != title_) {
      bar_.reset();
      bar_ = std::make_unique<ProgressBar>(title);
      title_ = title;
    }
    bar_->Show(fraction);
  }

 private:
  std::unique_ptr<ProgressBar> bar_;
  std::string title_;
};

Scene ReadOptionsScene(const Options& options) {
  Scene scene = ReadScene(options.scene);
  if (!options.hand.empty()) scene.hand.model = options.hand;
  if (options.profile.empty()) return scene;
  // Of the scene's own table, or else of the built-in one.
  scene.device.profile = options.profile;
  if (scene.device.file.empty()) return scene;
  const auto& built_in = DeviceProfiles();
  const bool known =
      std::any_of(built_in.begin(), built_in.end(), [&](const DeviceProfile& p) { return p.name == options.profile; });
  const std::vector<DeviceProfile> own = ParseDeviceProfiles(ReadTextFile(scene.device.file), scene.device.file);
  const bool in_own =
      std::any_of(own.begin(), own.end(), [&](const DeviceProfile& p) { return p.name == options.profile; });
  if (!in_own && known) scene.device.file.clear();
  return scene;
}

void RunProfiles(const Options& options, const Scene& scene) {
  std::vector<ProfileMargins> rows;
  bool complete = true;
  {
    Bars bars;
    rows = ExamineProfiles(
        scene, options.study, [&](const std::string& stage, double fraction) { bars.Show(stage, fraction); },
        &complete);
  }
  if (rows.empty() && !complete) throw Error("ended before anything was examined");
  fmt::print("{}", options.json ? FormatProfilesJson(scene, rows, complete) : FormatProfilesTable(rows));
  std::string broken;
  for (const ProfileMargins& row : rows) {
    if (Judge(row) == Judgement::kBroken)
      broken += fmt::format("{}{} in {}", broken.empty() ? "" : ", ", row.profile, row.hand);
  }
  if (!broken.empty()) {
    throw Error(fmt::format("the margins are below gain {:g} and {} tick of delay on {}", kLeastGainMargin,
                            kLeastDelayMargin_ticks, broken));
  }
  if (!complete) throw Error("ended before all devices were examined; those above are");
}

void RunSweep(Options& options, const Scene& scene) {
  options.sweep.seed = options.study.seed;
  options.sweep.stop = options.study.stop;
  if (!options.folder.empty() && std::filesystem::is_directory(options.folder)) {
    throw Error(fmt::format("{} is a folder; with --sweep, -o names a CSV file", options.folder));
  }
  SweepStudy study;
  {
    ProgressBar bar("sweeping the scene's numbers");
    study = SweepScene(scene, options.sweep, [&](const std::string&, double fraction) { bar.Show(fraction); });
  }
  if (!options.folder.empty()) WriteTextFile(options.folder, FormatSweepCsv(study));
  fmt::print("{}", options.json ? FormatSweepJson(study) : FormatSweepTable(study));
  if (const int failed = study.Count(SweepVerdict::kFail); failed > 0) {
    throw Error(fmt::format("{} of {} cases failed", failed, study.rows.size()));
  }
  if (!study.complete) throw Error(fmt::format("ended after {} cases, none of which failed", study.rows.size()));
}

void Run(Options& options) {
  const Scene scene = ReadOptionsScene(options);
  options.study.stop = &CatchInterrupt();
  if (options.sweeps) return RunSweep(options, scene);
  if (options.profiles) return RunProfiles(options, scene);
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) {
    CheckStabilityInputsStay(scene, options.scene, options.folder);
    lock.emplace(options.folder);  // before the long work
  }
  StabilityStudy study;
  {
    Bars bars;
    study = ExamineStability(scene, options.study,
                             [&](const std::string& stage, double fraction) { bars.Show(stage, fraction); });
  }
  // What was examined until an interruption does not take the place of earlier results.
  const bool keep = !study.complete && std::filesystem::exists(options.folder + "/stability.json");
  const bool write = !options.folder.empty() && !keep;
  if (write) WriteStabilityStudy(scene, study, options.folder);
  if (!options.folder.empty() && keep) Say("the earlier results in {}/ stay", options.folder);
  for (const std::string& warning : study.warnings) SayWarning("{}", warning);
  if (options.json) {
    fmt::print("{}", FormatStabilityJson(study));
  } else {
    PrintStudy(study);
    if (write) fmt::print("  results   {}/: {}\n", options.folder, fmt::join(study.files, " "));
  }
  if (!study.findings.empty()) {
    const std::size_t more = study.findings.size() - 1;
    throw Error(fmt::format("not stable: {}{}", study.findings.front(),
                            more > 0 ? fmt::format("; and {} more", more) : std::string()));
  }
  if (!study.complete) {
    throw Error(study.CountScenarios().judged + study.CountMargins().judged > 0
                    ? "ended before all was examined; what was examined is stable"
                    : "ended before anything was examined");
  }
}

}  // namespace

void AddStabilityCommand(CLI::App& app) {
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "stability", "Examine whether a scene's bone, tool, device, hand and gains are stable together; exit 1 when not");
  command->add_option("SCENE", options->scene, "The scene file (TOML; see 'kerf scene --defaults')")->required();
  command->add_option("-o,--output", options->folder,
                      "Folder for report, JSON, tables and figures; made when missing; without it none are written");
  command->add_option("--profile", options->profile,
                      "The device: one of the scene's table, or of those built in, instead of the scene's");
  command->add_option("--hand", options->hand, "The hand, H0 to H4, instead of the scene's [hand] model")
      ->transform(CLI::IsMember({"H0", "H1", "H2", "H3", "H4"}, CLI::ignore_case));
  auto* quick = command->add_flag("--quick", options->study.quick, "Fewer hands and a coarser map");
  command->add_option("--seed", options->study.seed, "Of what is left to chance in the scenarios; 0 and up")
      ->check([](const std::string& text) {
        const bool number =
            !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
        return number ? std::string() : fmt::format("\"{}\" is no whole number from 0 up", text);
      })
      ->capture_default_str();
  auto* as_asked = command->add_flag(
      "--as-asked", options->study.as_asked,
      "Examine the scene's coupling as it is written, without lowering it to what device and loop bear");
  auto* profiles = command->add_flag(
      "--profiles", options->profiles,
      "Only the margins, with the scene's gains, on every device built in and in every hand (minutes)");
  profiles->excludes(as_asked)->excludes("--profile")->excludes("--hand")->excludes("--output");
  auto* sweep = command->add_flag(
      "--sweep", options->sweeps,
      "Instead: every number of the scene at its least, default and greatest value, alone and in random pairs, a row "
      "each; -o names a CSV file then");
  sweep->excludes(as_asked)->excludes(profiles)->excludes(quick);
  command->add_option("--pairs", options->sweep.pairs, "Random pairs of the sweep")
      ->check(CLI::Range(0, 100000))
      ->capture_default_str()
      ->needs(sweep);
  command->add_option("--case-seconds", options->sweep.case_s, "Time limit of a case of the sweep, s")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str()
      ->needs(sweep);
  command
      ->add_option("--keys", options->sweep.only,
                   "Sweep only keys that begin with this, as \"effects.\"; may be "
                   "given many times")
      ->needs(sweep);
  command->add_flag("--json", options->json, "Print the results as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
