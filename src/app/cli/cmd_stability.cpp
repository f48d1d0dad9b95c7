// kerf stability: checks that a scene's bone, tool, device, hand and gains are stable together.
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
#include "app/cli/numbers.h"
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
#include "view/picture/picture.h"

namespace kerf::cli {
namespace {

struct StabilityArguments {
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
    // Prints every figure that violates its bound or, if there is none, the figure closest to its bound.
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

/// Progress bar for each stage; may be called from any thread.
class Bars {
 public:
  void Show(const std::string& now, double fraction) {
    // There is one bar for the whole work list, because its stages run in parallel.
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

Scene ReadOptionsScene(const StabilityArguments& options) {
  Scene scene = ReadScene(options.scene);
  if (!options.hand.empty()) scene.hand.model = options.hand;
  if (options.profile.empty()) return scene;
  // Take the profile from the scene's own table if it has one, otherwise from the built-in table.
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

void RunProfiles(const StabilityArguments& options, const Scene& scene) {
  std::vector<ProfileMargins> rows;
  bool complete = true;
  {
    Bars bars;
    rows = ExamineProfiles(
        scene, options.study, [&](const std::string& stage, double fraction) { bars.Show(stage, fraction); },
        &complete);
  }
  if (rows.empty() && !complete) throw Error("stopped before anything was examined");
  fmt::print("{}", options.json ? FormatProfilesJson(scene, rows, complete) : FormatProfilesTable(rows));
  std::string broken;
  for (const ProfileMargins& row : rows) {
    if (Judge(row) == Judgement::kBroken)
      broken += fmt::format("{}{} in {}", broken.empty() ? "" : ", ", row.profile, row.hand);
  }
  if (!broken.empty()) {
    throw Error(fmt::format("the gain margin is below {:g}, or the delay margin below {} tick, on {}", kMinGainMargin,
                            kMinDelayMargin_ticks, broken));
  }
  if (!complete) throw Error("stopped before all devices were examined; only those listed above were");
}

void RunSweep(StabilityArguments& options, const Scene& scene) {
  options.sweep.seed = options.study.seed;
  options.sweep.stop = options.study.stop;
  if (!options.folder.empty() && std::filesystem::is_directory(options.folder)) {
    throw Error(fmt::format("{} is a folder; with --sweep, -o must be a CSV file", options.folder));
  }
  SweepStudy study;
  {
    ProgressBar bar("sweeping the scene's numbers");
    study = SweepScene(scene, options.sweep, [&](const std::string&, double fraction) { bar.Show(fraction); });
  }
  // The rows of an interrupted sweep do not overwrite earlier ones.
  const bool keep = !study.complete && std::filesystem::exists(options.folder);
  if (!options.folder.empty() && !keep) WriteTextFile(options.folder, FormatCsv(SweepColumns(), study.rows));
  if (!options.folder.empty() && keep) Say("the earlier results in {} are kept", options.folder);
  fmt::print("{}", options.json ? FormatSweepJson(study) : FormatSweepTable(study));
  if (const int failed = study.Count(SweepVerdict::kFail); failed > 0) {
    throw Error(fmt::format("{} of {} cases failed", failed, study.rows.size()));
  }
  if (!study.complete) throw Error(fmt::format("stopped after {} cases, none of which failed", study.rows.size()));
}

void Run(StabilityArguments& options) {
  const Scene scene = ReadOptionsScene(options);
  options.study.stop = &CatchInterrupt();
  if (options.sweeps) return RunSweep(options, scene);
  if (options.profiles) return RunProfiles(options, scene);
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) {
    RequirePictures();
    CheckStabilityInputsNotOverwritten(scene, options.scene, options.folder);
    lock.emplace(options.folder);  // taken before the long computation
  }
  StabilityStudy study;
  {
    Bars bars;
    study = ExamineStability(scene, options.study,
                             [&](const std::string& stage, double fraction) { bars.Show(stage, fraction); });
  }
  // The results of an interrupted run must not overwrite earlier results.
  const bool keep = !study.complete && std::filesystem::exists(options.folder + "/stability.json");
  const bool write = !options.folder.empty() && !keep;
  if (write) WriteStabilityStudy(scene, study, options.folder);
  if (!options.folder.empty() && keep) Say("the earlier results in {}/ are kept", options.folder);
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
                    ? "stopped before all cases were examined; those examined are stable"
                    : "stopped before anything was examined");
  }
}

}  // namespace

void AddStabilityCommand(CLI::App& app) {
  const auto options = std::make_shared<StabilityArguments>();
  CLI::App* command = app.add_subcommand(
      "stability",
      "Examine whether a scene's bone, tool, device, hand and gains are stable together; exit with 1 if not");
  command->add_option("SCENE", options->scene, "Scene file (TOML; see 'kerf scene --defaults')")->required();
  command->add_option("-o,--output", options->folder,
                      "Folder for report, JSON, tables and figures; created if missing; default: no files are written");
  command->add_option("--profile", options->profile,
                      "Device profile of the scene's table or built in, instead of the scene's [device] profile");
  command->add_option("--hand", options->hand, "Hand model, H0 to H4, instead of the scene's [hand] model")
      ->transform(CLI::IsMember({"H0", "H1", "H2", "H3", "H4"}, CLI::ignore_case));
  auto* quick = command->add_flag("--quick", options->study.quick, "Use fewer hands and a coarser map");
  AddNumberOption(*command, "--seed", options->study.seed, "seed", Range{0, 1e9},
                  "seed of the random parts of the scenarios")
      ->capture_default_str();
  auto* as_asked =
      command->add_flag("--as-asked", options->study.as_asked,
                        "Examine the scene's coupling as given, without lowering it to the limits of device and loop");
  auto* profiles = command->add_flag(
      "--profiles", options->profiles,
      "Examine only the margins, with the scene's gains, on every built-in device and in every hand (minutes)");
  profiles->excludes(as_asked)->excludes("--profile")->excludes("--hand")->excludes("--output");
  auto* sweep = command->add_flag("--sweep", options->sweeps,
                                  "Sweep every number of the scene instead: minimum, default and maximum, alone and in "
                                  "random pairs, a row each; -o is then a CSV file");
  sweep->excludes(as_asked)->excludes(profiles)->excludes(quick);
  AddNumber(*command, "--pairs", options->sweep, "pairs")->capture_default_str()->needs(sweep);
  AddNumber(*command, "--case-seconds", options->sweep, "case_s")->capture_default_str()->needs(sweep);
  command
      ->add_option("--keys", options->sweep.only,
                   "Beginning of the keys to sweep, such as \"effects.\"; may be repeated")
      ->needs(sweep);
  command->add_flag("--json", options->json, "Print as JSON");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
