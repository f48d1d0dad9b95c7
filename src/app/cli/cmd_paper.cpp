// kerf paper: compares the printed values of the paper's Tables 1 to 6 with computed ones, and lists the places where
// its text and tables disagree.
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "app/cli/commands.h"
#include "app/cli/paper_figure.h"
#include "app/cli/paper_output.h"
#include "base/files/files.h"

namespace kerf::cli {
namespace {

struct PaperArguments {
  bool json = false;
  bool csv = false;
  bool markdown = false;
  std::string figure;
  std::string output;
};

std::string Format(const PaperTables& tables, const PaperArguments& options) {
  if (options.json) return FormatPaperJson(tables);
  if (options.csv) return FormatPaperCsv(tables);
  if (options.markdown) return FormatPaperMarkdown(tables);
  return FormatPaperText(tables);
}

void Run(const PaperArguments& options) {
  if (!options.figure.empty()) {
    if (std::filesystem::path(options.figure).extension() != ".png") {
      throw CLI::ValidationError("--figure", fmt::format("'{}' must end in .png", options.figure));
    }
    if (!options.output.empty() && IsSameFile(options.figure, options.output)) {
      throw CLI::ValidationError("--figure", fmt::format("'{}' is the same file as that given by -o", options.figure));
    }
    CheckWritable(options.figure);
  }
  if (!options.output.empty()) CheckWritable(options.output);
  const PaperTables tables = CalcPaperTables();
  if (!options.figure.empty()) WritePaperFigure(tables, options.figure);
  const std::string text = Format(tables, options);
  if (options.output.empty()) {
    std::fwrite(text.data(), 1, text.size(), stdout);
  } else {
    WriteTextFile(options.output, text);
  }
}

}  // namespace

void AddPaperCommand(CLI::App& app) {
  const auto options = std::make_shared<PaperArguments>();
  CLI::App* command = app.add_subcommand(
      "paper", "Recompute the tables of the paper that kerf implements, and show where its text and tables disagree");
  CLI::Option* json = command->add_flag("--json", options->json, "Print as JSON");
  CLI::Option* csv = command->add_flag("--csv", options->csv, "Print as CSV: a row for each of the 24 forces");
  command->add_flag("--markdown", options->markdown, "Print as Markdown: the table of docs/paper.md")
      ->excludes(json)
      ->excludes(csv);
  csv->excludes(json);
  command->add_option("--figure", options->figure,
                      "Picture of force against depth to write, computed and corrected (.png, 1920 x 1080 pixels)");
  command->add_option("-o,--output", options->output, "File for the output; default: stdout");
  command->callback([options] { Run(*options); });
}

}  // namespace kerf::cli
