#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/commands.h"
#include "app/cli/log_columns.h"
#include "app/cli/reference.h"
#include "base/files/files.h"
#include "kerf/version.h"
#include "kerf_components.h"
#include "session/export/write_export.h"
#include "session/practise/history.h"
#include "session/run/force_log.h"
#include "session/run/run.h"
#include "session/run/run_slab.h"
#include "session/score/measures.h"
#if KERF_WITH_EXPERIMENTS
#include "experiment/bench/growth.h"
#include "experiment/calibration/measurements.h"
#include "experiment/compare/compare_files.h"
#include "experiment/device_bench/exchange_bench.h"
#include "experiment/effect_costs/effect_costs.h"
#include "experiment/hour/hour.h"
#include "experiment/stability_study/stability_files.h"
#include "experiment/stability_study/sweep.h"
#include "experiment/study/study_csv.h"
#include "experiment/uncertainty/band.h"
#include "experiment/validation/validation_files.h"
#endif

namespace kerf::cli {
namespace {

/// Makes the reference of the whole program. `command`: any of its commands.
CommandReference MakeProgramReference(const CLI::App& command) {
  return MakeReference(*command.get_parent());
}

#if KERF_WITH_EXPERIMENTS
std::string DescribeMeasurements() {
  std::vector<std::pair<std::string, std::string>> columns;
  for (const MeasurementColumn& column : MeasurementColumns()) columns.emplace_back(column.name, column.meaning);
  return DescribeColumns(columns, "column");
}
#endif

/// Returns a section in Markdown for each table whose columns the program describes: a line that names it, the meanings
/// of its columns, and a closing line. tools/docs puts each section in its place in docs/formats.md.
std::string FormatTableColumns() {
  std::string text;
  const auto add = [&text](const char* table, const std::string& columns) {
    text += fmt::format("<!-- columns of {} -->\n\n{}\n<!-- end -->\n", table, columns);
  };
  add("forces.csv of kerf run", DescribeColumns(ForceColumns()));
  add("slab.csv", DescribeColumns(SlabColumns()));
  add("forces.csv of kerf loop", DescribeColumns(LoopColumns()));
  add("kerf log --csv", DescribeColumns(LogStateColumns()));
  add("kerf log --csv --ticks", DescribeColumns(LogTickColumns()));
  add("measures.csv", DescribeColumns(ExportColumns()));
  add("kerf score --csv", DescribeColumns(SheetColumns()));
  add("kerf practise --history --csv", DescribeColumns(HistoryColumns()));
#if KERF_WITH_EXPERIMENTS
  Comparison comparison;
  comparison.cases.resize(1);
  comparison.cases.front().what.id = "CASE";
  add("the data of kerf calibrate", DescribeMeasurements());
  add("compare.csv", DescribeColumns(CompareColumns(comparison)));
  const Validation validation;
  add("values.csv", DescribeColumns(ValueColumns(validation)));
  add("trends.csv", DescribeColumns(TrendColumns(validation)));
  add("teeth.csv", DescribeColumns(ToothColumns(validation)));
  add("blades.csv", DescribeColumns(BladeColumns(validation)));
  add("band.csv", DescribeColumns(BandColumns()));
  add("cases.csv", DescribeColumns(CaseColumns()));
  add("cases_times.csv", DescribeColumns(BucketColumns()));
  add("references.csv", DescribeColumns(ReferenceColumns()));
  add("figures.csv", DescribeColumns(FigureColumns()));
  add("margins.csv", DescribeColumns(MarginColumns()));
  add("map.csv", DescribeColumns(MapColumns({})));
  add("kerf stability --sweep", DescribeColumns(SweepColumns()));
  add("kerf effects --csv", DescribeColumns(EffectCostColumns()));
  add("hour.csv", DescribeColumns(HourColumns()));
  add("growth.csv", DescribeColumns(GrowthColumns()));
  add("kerf bench devices --json", DescribeColumns(ExchangeColumns(), "key"));
#endif
  return text;
}

void WriteManPages(const CommandReference& command, const std::string& folder) {
  WriteTextFile((std::filesystem::path(folder) / ManPageName(command)).string(),
                FormatManPage(command, VersionString()));
  for (const CommandReference& child : command.commands) WriteManPages(child, folder);
}

}  // namespace

void AddReferenceCommand(CLI::App& app) {
  struct Options {
    std::string folder;
    bool json = false;
    bool columns = false;
  };
  const auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand(
      "reference", "Print the reference of all commands as Markdown, or write the manual pages into a folder");
  CLI::Option* man =
      command->add_option("--man", options->folder, "Write manual pages (kerf.1, kerf-run.1, ...) into this folder");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON")->excludes(man);
  command
      ->add_flag("--columns", options->columns,
                 "Print, as Markdown, the columns of all tables that kerf writes (part of docs/formats.md)")
      ->excludes(man)
      ->excludes(json);
  command->callback([options, command] {
    const CommandReference root = MakeProgramReference(*command);
    if (options->columns) {
      fmt::print("{}", FormatTableColumns());
    } else if (!options->folder.empty()) {
      MakeFolder(options->folder);
      WriteManPages(root, options->folder);
    } else {
      fmt::print("{}", options->json ? FormatReferenceJson(root) : FormatReferenceMarkdown(root));
    }
  });
}

void AddCompletionCommand(CLI::App& app) {
  const auto shell = std::make_shared<std::string>();
  CLI::App* command =
      app.add_subcommand("completion", "Print a completion script for a shell: commands, options, files");
  command->add_option("SHELL", *shell, "The shell")->required()->check(CLI::IsMember({"bash", "zsh", "fish"}));
  command->callback([shell, command] {
    const CommandReference root = MakeProgramReference(*command);
    fmt::print("{}", *shell == "bash"  ? FormatBashCompletion(root)
                     : *shell == "zsh" ? FormatZshCompletion(root)
                                       : FormatFishCompletion(root));
  });
}

}  // namespace kerf::cli
