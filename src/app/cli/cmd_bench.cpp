// kerf bench: measures execution times.
#include <fmt/format.h>

#include <cstdio>
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
#include "experiment/bench/tick_cases.h"
#include "experiment/bench/tick_report.h"
#include "experiment/bench/undo_bench.h"
#include "experiment/device_bench/exchange_bench.h"
#include "experiment/draw_bench/view_bench.h"
#include "experiment/hour/hour.h"
#include "kerf/error.h"
#include "kerf/version.h"
#include "session/scene/scene.h"

namespace kerf::cli {
namespace {

struct BenchArguments {
  std::vector<std::string> cases;
  BenchOptions bench;
  std::string width;
  std::string output;
  bool json = false;
  bool markdown = false;
};

void Run(BenchArguments& options) {
  if (!options.output.empty()) CheckWritable(options.output);
  try {
    CheckTickCases(options.cases);
  } catch (const Error& e) {
    throw CLI::ValidationError("--case", e.what());
  }
  SetVectorTarget(options.width);
  TickReport report;
  report.vector_width = VectorTarget();
  report.machine = LookAtMachine();
  report.core = options.bench.core;
  report.realtime = options.bench.realtime;
  report.ticks = options.bench.ticks;
  {
    StageBars bars;
    options.bench.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    report.results = RunTickCases(options.cases, options.bench);
  }
  for (const std::string& warning : FindTickWarnings(report)) SayWarning("{}", warning);
  const std::string text = options.json       ? FormatTickJson(report)
                           : options.markdown ? FormatTickMarkdown(report)
                                              : FormatTickTable(report);
  if (options.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteTextFile(options.output, text);
  }
}

struct UndoCommand {
  UndoBenchOptions bench;
  std::string output;
  bool json = false;
  bool markdown = false;
};

void RunUndo(UndoCommand& command) {
  if (!command.output.empty()) CheckWritable(command.output);
  UndoReport report;
  {
    StageBars bars;
    command.bench.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    report = RunUndoBench(command.bench);
  }
  const std::string text = command.json       ? FormatUndoJson(report)
                           : command.markdown ? FormatUndoMarkdown(report)
                                              : FormatUndoTable(report);
  if (command.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteTextFile(command.output, text);
  }
}

void AddUndoBench(CLI::App& group) {
  const auto options = std::make_shared<UndoCommand>();
  CLI::App* command = group.add_subcommand("undo",
                                           "Time undo and redo of 1, 5 and 20 cuts through the default mandible, and "
                                           "the time that undo adds to a tick; with hashes of the bone");
  AddNumber(*command, "--rounds", options->bench, "rounds")->capture_default_str();
  AddNumber(*command, "--voxel", options->bench, "voxel_mm")->capture_default_str();
  AddNumber(*command, "--leaves-per-tick", options->bench, "leaves_per_tick")->capture_default_str();
  AddNumber(*command, "--core", options->bench, "core")->capture_default_str();
  command->add_flag("--realtime", options->bench.realtime, "Use real-time priority (SCHED_FIFO), as the loop does");
  command->add_option("-o,--output", options->output, "File for the report; default: stdout");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: the table of docs/reliability.md")
      ->excludes(json);
  command->callback([options] { RunUndo(*options); });
}

}  // namespace

namespace {

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
  const MachineState machine = LookAtMachine();
  Hour hour;
  {
    StageBars bars;
    hour = RunHour(scene, options.hour, [&](const std::string& now, double fraction) { bars.Show(now, fraction); });
  }
  if (!options.folder.empty()) WriteHour(hour, options.folder);
  if (options.markdown) {
    const std::string words =
        fmt::format("{}; load {:.1f} before the run; commit {}. Made by `tools/reliability_figures`.", machine.cpu,
                    machine.load, CommitString());
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

}  // namespace

namespace {

struct ViewCommand {
  ViewBenchOptions bench;
  std::string output;
  bool json = false;
  bool markdown = false;
};

void RunView(ViewCommand& command) {
  if (!command.output.empty()) CheckWritable(command.output);
  ViewReport report;
  {
    StageBars bars;
    command.bench.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    report = RunViewBench(command.bench);
  }
  const std::string text = command.json       ? FormatViewJson(report)
                           : command.markdown ? FormatViewMarkdown(report)
                                              : FormatViewTable(report);
  if (command.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteTextFile(command.output, text);
  }
}

void AddViewBench(CLI::App& group) {
  const auto options = std::make_shared<ViewCommand>();
  CLI::App* command = group.add_subcommand(
      "view", "Time the drawing of the default mandible while it is cut: first picture, changed chunks, frames");
  for (const char* key : {"width", "height", "scale", "frames"}) {
    AddNumber(*command, std::string("--") + key, options->bench, key)->capture_default_str();
  }
  AddNumber(*command, "--voxel", options->bench, "voxel_mm")->capture_default_str();
  AddNumber(*command, "--cut", options->bench, "cut_mm")->capture_default_str();
  command->add_option("-o,--output", options->output, "File for the report; default: stdout");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: the table of docs/window.md")->excludes(json);
  command->callback([options] { RunView(*options); });
}

}  // namespace

namespace {

struct DevicesCommand {
  ExchangeBenchOptions bench;
  DeviceOption device;
  int timeout_ms = 0;  // 0: each driver's own default
  std::string output;
  bool models_only = false;
  bool json = false;
  bool markdown = false;
};

void RunDevices(DevicesCommand& command) {
  if (!command.output.empty()) CheckWritable(command.output);
  DriverOptions drivers = MakeDriverOptions(command.device);
  if (command.timeout_ms > 0) {
    drivers.falcon.timeout_ms = drivers.bridge.timeout_ms = drivers.haply.timeout_ms = command.timeout_ms;
  }
  command.bench.stop = &CatchInterrupt();
  std::vector<ExchangeTimes> results;
  {
    StageBars bars;
    command.bench.progress = [&](const std::string& now, double fraction) { bars.Show(now, fraction); };
    results = BenchModels(command.bench);
    if (!command.models_only) {
      LibusbBus bus;
      for (const FoundDevice& found : FindDevices(bus, drivers)) {
        results.push_back(BenchDevice(bus, found, drivers, command.bench));
      }
    }
  }
  const std::string text = command.json       ? FormatExchangeJson(results)
                           : command.markdown ? FormatExchangeMarkdown(results)
                                              : FormatExchangeTable(results);
  if (command.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteTextFile(command.output, text);
  }
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
  command->add_option("-o,--output", options->output, "File for the report; default: stdout");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: the table of docs/emulated-usb.md")
      ->excludes(json);
  command->callback([options] { RunDevices(*options); });
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("bench", "Measure the speed of kerf, compared with baselines of the same run");
  group->require_subcommand(1);
  AddUndoBench(*group);
  AddHourCommand(*group);
  AddViewBench(*group);
  AddDevicesBench(*group);
  const auto options = std::make_shared<BenchArguments>();
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
  command
      ->add_option("--width", options->width,
                   fmt::format("Vector instructions for the removal, which do not change the bone; default: the widest "
                               "of this machine. This machine has: {}",
                               fmt::join(VectorTargets(), ", ")))
      ->check(CLI::IsMember(VectorTargets()));
  command->add_option("-o,--output", options->output, "File for the report; default: stdout");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: a table of docs/benchmarks.md")
      ->excludes(json);
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
