// kerf bench: measures execution times.
#include <fmt/format.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/device_option.h"
#include "app/cli/message.h"
#include "app/cli/numbers.h"
#include "app/cli/progress.h"
#include "app/cli/signals.h"
#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "cut/removal/carve.h"
#include "device/drivers/libusb_bus.h"
#include "experiment/bench/growth.h"
#include "experiment/bench/tick_cases.h"
#include "experiment/bench/tick_report.h"
#include "experiment/bench/undo_bench.h"
#include "experiment/device_bench/exchange_bench.h"
#include "experiment/draw_bench/view_bench.h"
#include "experiment/hour/hour.h"
#include "kerf/error.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

/// A benchmark, where its report goes and in which form.
template <typename Options>
struct BenchCommand {
  Options bench;
  std::string output;
  bool json = false;
  bool markdown = false;
};

/// `page`: the page of docs for which the Markdown is made.
template <typename Options>
void AddReportOptions(CLI::App& command, BenchCommand<Options>& options, const std::string& page) {
  command.add_option("-o,--output", options.output, "File for the report; default: stdout");
  CLI::Option* json = command.add_flag("--json", options.json, "Print as JSON");
  command.add_flag("--markdown", options.markdown, fmt::format("Print as Markdown: {}", page))->excludes(json);
}

template <typename Report>
std::vector<std::string> FindWarnings(const Report& /*report*/) {
  return {};
}
std::vector<std::string> FindWarnings(const TickReport& report) {
  return FindTickWarnings(report);
}

/// Runs the benchmark with a progress bar, and prints its report or writes it to a file.
template <typename Options, typename Report>
void RunBench(BenchCommand<Options>& command, const std::function<Report()>& measure,
              std::string (&table)(const Report&), std::string (&markdown)(const Report&),
              std::string (&json)(const Report&)) {
  if (!command.output.empty()) CheckWritable(command.output);
  Report report;
  {
    StageBars bars;
    command.bench.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    report = measure();
  }
  for (const std::string& warning : FindWarnings(report)) SayWarning("{}", warning);
  const std::string text = command.json ? json(report) : command.markdown ? markdown(report) : table(report);
  if (command.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteTextFile(command.output, text);
  }
}

struct TickCommand : BenchCommand<BenchOptions> {
  std::vector<std::string> cases;
  std::string width;
};

void RunTick(TickCommand& options) {
  try {
    CheckTickCases(options.cases);
  } catch (const Error& e) {
    throw CLI::ValidationError("--case", e.what());
  }
  try {
    SetVectorTarget(options.width);
  } catch (const Error& e) {
    throw CLI::ValidationError("--width", e.what());
  }
  const auto measure = [&options] {
    TickReport report;
    report.run = ReadRunInfo(options.bench.core, options.bench.realtime);
    report.run.vector_width = VectorTarget();
    report.ticks = options.bench.ticks;
    report.results = RunTickCases(options.cases, options.bench);
    return report;
  };
  RunBench<BenchOptions, TickReport>(options, measure, FormatTickTable, FormatTickMarkdown, FormatTickJson);
}

void AddUndoBench(CLI::App& group) {
  const auto options = std::make_shared<BenchCommand<UndoBenchOptions>>();
  CLI::App* command = group.add_subcommand("undo",
                                           "Time undo and redo of 1, 5 and 20 cuts through the default mandible, and "
                                           "the time that undo adds to a tick; with hashes of the bone");
  AddNumber(*command, "--rounds", options->bench, "rounds")->capture_default_str();
  AddNumber(*command, "--voxel", options->bench, "voxel_mm")->capture_default_str();
  AddNumber(*command, "--leaves-per-tick", options->bench, "leaves_per_tick")->capture_default_str();
  AddNumber(*command, "--core", options->bench, "core")->capture_default_str();
  command->add_flag("--realtime", options->bench.realtime, "Use real-time priority (SCHED_FIFO), as the loop does");
  AddReportOptions(*command, *options, "the table of docs/reliability.md");
  command->callback([options] {
    RunBench<UndoBenchOptions, UndoReport>(
        *options, [&] { return RunUndoBench(options->bench); }, FormatUndoTable, FormatUndoMarkdown, FormatUndoJson);
  });
}

struct HourCommand {
  std::string scene;
  std::string folder;
  HourOptions hour;
  bool markdown = false;
};

void RunHourCommand(HourCommand& options) {
  const Scene scene = ReadScene(options.scene);
  std::optional<FolderLock> lock;
  if (!options.folder.empty()) {
    lock.emplace(options.folder);
    for (const char* name : {"/hour.csv", "/hour.png"}) CheckWritable(options.folder + name);
  }
  options.hour.stop = &CatchInterrupt();
  const RunInfo run = ReadRunInfo();
  Hour hour;
  {
    StageBars bars;
    hour = RunHour(scene, options.hour, [&](const std::string& now, double fraction) { bars.Show(now, fraction); });
  }
  if (!options.folder.empty()) WriteHour(hour, options.folder);
  if (options.markdown) {
    const std::string words = DescribeRun(run) + ". Made by `tools/reliability_figures`.";
    fmt::print("{}", FormatHourMarkdown(hour, words, "reliability/hour.png"));
  } else {
    fmt::print("{}", FormatHourTable(hour));
  }
  if (hour.loop.end != LoopEnd::kRequested) throw Error(fmt::format("the loop ended early: {}", hour.loop.failure));
}

void AddHourCommand(CLI::App& group) {
  const auto options = std::make_shared<HourCommand>();
  CLI::App* command = group.add_subcommand(
      "hour", "Simulate an hour of sawing, and report memory, tick times, force at rest and sums for each minute");
  command->add_option("SCENE", options->scene, "Scene file (TOML), such as scenes/one_hour.toml")->required();
  AddNumber(*command, "--minutes", options->hour, "minutes")->capture_default_str();
  command->add_option("-o,--output", options->folder, "Folder for hour.csv and hour.png; created if missing");
  command->add_option("--log", options->hour.folder, "Existing folder for the loop's log, which is removed at the end");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: the table of docs/reliability.md");
  command->callback([options] { RunHourCommand(*options); });
}

struct GrowthCommand {
  GrowthOptions bench;
  std::string folder;
  bool markdown = false;
};

void RunGrowth(GrowthCommand& command) {
  std::optional<FolderLock> lock;
  if (!command.folder.empty()) {
    lock.emplace(command.folder);
    for (const char* name : {"/growth.csv", "/growth.png"}) CheckWritable(command.folder + name);
  }
  GrowthReport report;
  {
    StageBars bars;
    command.bench.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    report = MeasureGrowth(PlanGrowth(), command.bench);
  }
  if (!command.folder.empty()) WriteGrowth(report, command.folder);
  fmt::print("{}", command.markdown ? FormatGrowthMarkdown(report) : FormatGrowthTable(report));
}

void AddGrowthBench(CLI::App& group) {
  const auto options = std::make_shared<GrowthCommand>();
  CLI::App* command = group.add_subcommand(
      "growth",
      "Measure how the time of a tick and memory grow with the voxel edge, the disc, the bone, the feed, the effects "
      "and the pieces; with exponents");
  AddNumber(*command, "--ticks", options->bench, "ticks")->capture_default_str();
  AddNumber(*command, "--core", options->bench, "core")->capture_default_str();
  command->add_flag("--realtime", options->bench.realtime, "Use real-time priority (SCHED_FIFO), as the loop does");
  command->add_option("-o,--output", options->folder, "Folder for growth.csv and growth.png; created if missing");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: a table of docs/benchmarks.md");
  command->callback([options] { RunGrowth(*options); });
}

void AddViewBench(CLI::App& group) {
  const auto options = std::make_shared<BenchCommand<ViewBenchOptions>>();
  CLI::App* command = group.add_subcommand(
      "view", "Time the drawing of the default mandible while it is cut: first picture, changed chunks, frames");
  for (const char* key : {"width", "height", "scale", "frames"}) {
    AddNumber(*command, std::string("--") + key, options->bench, key)->capture_default_str();
  }
  AddNumber(*command, "--voxel", options->bench, "voxel_mm")->capture_default_str();
  AddNumber(*command, "--cut", options->bench, "cut_mm")->capture_default_str();
  AddReportOptions(*command, *options, "the table of docs/window.md");
  command->callback([options] {
    RunBench<ViewBenchOptions, ViewReport>(
        *options, [&] { return RunViewBench(options->bench); }, FormatViewTable, FormatViewMarkdown, FormatViewJson);
  });
}

struct DevicesCommand : BenchCommand<ExchangeBenchOptions> {
  DeviceOption device;
  int timeout_ms = 0;  // 0: each driver's own default
  bool models_only = false;
};

void RunDevices(DevicesCommand& command) {
  DriverOptions drivers = MakeDriverOptions(command.device);
  if (command.timeout_ms > 0) {
    drivers.falcon.timeout_ms = drivers.bridge.timeout_ms = drivers.haply.timeout_ms = command.timeout_ms;
  }
  command.bench.stop = &CatchInterrupt();
  const auto measure = [&] {
    std::vector<ExchangeTimes> results = BenchModels(command.bench);
    if (command.models_only) return results;
    LibusbBus bus;
    for (const FoundDevice& found : FindDevices(bus, drivers)) {
      results.push_back(BenchDevice(bus, found, drivers, command.bench));
    }
    return results;
  };
  RunBench<ExchangeBenchOptions, std::vector<ExchangeTimes>>(command, measure, FormatExchangeTable,
                                                             FormatExchangeMarkdown, FormatExchangeJson);
}

void AddDevicesBench(CLI::App& group) {
  const auto options = std::make_shared<DevicesCommand>();
  CLI::App* command = group.add_subcommand("devices",
                                           "Time an exchange with each device: with models of all kinds in this "
                                           "process, and with connected devices, without force");
  AddNumber(*command, "--rounds", options->bench, "rounds")->capture_default_str();
  AddNumber(*command, "--rate", options->bench, "rate_hz")->capture_default_str();
  AddNumberOption(*command, "--timeout-ms", options->timeout_ms, "timeout_ms", FindRange<FalconOptions>("timeout_ms"),
                  "timeout of an exchange with a connected Falcon, bridge or Inverse3; default: 10 (Inverse3: 20). "
                  "Other devices have fixed timeouts");
  command->add_flag("--realtime", options->bench.realtime, "Use real-time priority (SCHED_FIFO), as the loop does");
  command->add_flag("--models-only", options->models_only, "Do not open connected devices");
  AddDriverOptions(*command, options->device);
  AddReportOptions(*command, *options, "the table of docs/emulated-usb.md");
  command->callback([options] { RunDevices(*options); });
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("bench", "Measure the speed of kerf, compared with baselines of the same run");
  group->require_subcommand(1);
  AddUndoBench(*group);
  AddHourCommand(*group);
  AddGrowthBench(*group);
  AddViewBench(*group);
  AddDevicesBench(*group);
  const auto options = std::make_shared<TickCommand>();
  CLI::App* command = group->add_subcommand(
      "tick", "Time whole ticks of the coupled simulation on one core, with the error and a hash of each result");
  command
      ->add_option(
          "--case", options->cases,
          fmt::format("Cases to run, separated by commas; may be repeated; default: all (some minutes). One of: {}",
                      fmt::join(NamesOfTickCases(), ", ")))
      ->delimiter(',');
  AddNumber(*command, "--ticks", options->bench, "ticks")->capture_default_str();
  AddNumber(*command, "--core", options->bench, "core")->capture_default_str();
  command->add_flag("--realtime", options->bench.realtime, "Use real-time priority (SCHED_FIFO), as the loop does");
  command->add_flag("--without-effects", options->bench.without_effects, "Omit the friction in the kerf");
  command->add_option("--width", options->width,
                      "Vector instructions of the tick, which do not change its results: avx3, avx2, sse4, ssse3 or "
                      "scalar, if the machine has them; default: the widest that it has");
  AddReportOptions(*command, *options, "a table of docs/benchmarks.md");
  command->callback([options] { RunTick(*options); });
}

}  // namespace kerf::cli
