// kerf bench: how fast it is.
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "bench/tick_cases.h"
#include "bench/tick_report.h"
#include "cli/commands.h"
#include "cli/progress.h"
#include "files/files.h"
#include "kerf/error.h"
#include "removal/carve.h"

namespace kerf::cli {
namespace {

struct Options {
  std::vector<std::string> cases;
  BenchOptions bench;
  std::string width;
  std::string output;
  bool json = false;
  bool markdown = false;
};

void Run(Options& options) {
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
  for (const std::string& doubt : FindTickDoubts(report)) fmt::print(stderr, "kerf: warning: {}\n", doubt);
  const std::string text = options.json       ? FormatTickJson(report)
                           : options.markdown ? FormatTickMarkdown(report)
                                              : FormatTickTable(report);
  if (options.output.empty()) {
    fmt::print("{}", text);
  } else {
    WriteTextFile(options.output, text);
  }
}

}  // namespace

void AddBenchCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand("bench", "Measure how fast kerf is, beside baselines of the same run");
  group->require_subcommand(1);
  const auto options = std::make_shared<Options>();
  CLI::App* command = group->add_subcommand(
      "tick",
      "Time whole ticks of the coupled simulation on one core, with the error and a hash of the result beside each "
      "speed");
  command
      ->add_option(
          "--case", options->cases,
          fmt::format("Cases to run, separated by commas or by repeating the option. Default: all, which takes "
                      "some minutes. They are: {}",
                      fmt::join(NamesOfTickCases(), ", ")))
      ->delimiter(',');
  command
      ->add_option(
          "--ticks", options->bench.ticks,
          "Ticks measured of each case, 1 to 10000000; where a cut is too short it is done again on fresh bones, "
          "as a whole")
      ->check(CLI::Range(1, 10000000))
      ->capture_default_str();
  command->add_option("--core", options->bench.core, "Core that the ticks are held to, from 0")
      ->check(CLI::Range(0, 4095))
      ->capture_default_str();
  command->add_flag("--realtime", options->bench.realtime,
                    "Let the ticks and the baselines go before other programs (SCHED_FIFO), as the loop does");
  command->add_flag("--without-effects", options->bench.without_effects,
                    "Without friction in the kerf, which the cuts have else");
  command
      ->add_option(
          "--width", options->width,
          fmt::format("Vector instructions that the removal uses; the bone comes out the same with each. Default: "
                      "the widest that this machine has. It has: {}",
                      fmt::join(VectorTargets(), ", ")))
      ->check(CLI::IsMember(VectorTargets()));
  command->add_option("-o,--output", options->output, "File for the report instead of stdout");
  CLI::Option* json = command->add_flag("--json", options->json, "Report as JSON");
  command->add_flag("--markdown", options->markdown, "Report as the Markdown tables of the README")->excludes(json);
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
