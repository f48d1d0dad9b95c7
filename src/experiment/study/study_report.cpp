#include "experiment/study/study_report.h"

#include <fmt/format.h>

#include <iterator>

#include "base/files/files.h"
#include "base/files/markdown_text.h"
#include "experiment/study/figures.h"
#include "experiment/study/study_words.h"
#include "session/run/results_folder.h"

namespace kerf {
namespace {

template <typename... Args>
void Add(std::string& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

void AddPart(std::string& text, const char* heading, const std::string& words, const std::string& table) {
  if (table.empty()) return;
  Add(text, "### {}\n\n{}{}{}", heading, words, words.empty() ? "" : "\n\n", table);
}

/// Under the heading of each table of force errors.
std::string ForceNote() {
  return fmt::format(
      "Force, p95: of |F - R| / max(|R|, {0:g} N), so a force below {0:g} N is judged as one of {0:g} N.",
      kLeastForce_N);
}
constexpr const char* kImpulseNote =
    " Impulse: (integral of |F| - integral of |R|) / integral of |R| over the path; above 0 the force is too large in "
    "all, below 0 too small; empty: not recorded by the version that made this case.";

void AddFigures(std::string& text, const std::vector<StudyFigure>& figures, Holding holding, bool convergence) {
  const std::string ending = fmt::format("_{}", ToString(holding));
  for (const StudyFigure& figure : figures) {
    const bool one_knob = figure.name.starts_with("convergence_") || figure.name.starts_with("volume_") ||
                          figure.name.starts_with("surface_");
    if (!figure.name.ends_with(ending) || one_knob != convergence) continue;
    Add(text, "![{}]({}.png)\n\n{} [SVG]({}.svg)\n\n", figure.plot.title, figure.name, figure.caption, figure.name);
  }
}

void AddHolding(std::string& text, const StudyResults& study, Holding holding,
                const std::vector<StudyFigure>& figures) {
  Add(text, "## The {}\n\n", DescribeHolding(holding));
  AddFigures(text, figures, holding, false);
  AddPart(text, "The defaults, path by path", ForceNote() + kImpulseNote, DefaultsTable(study, holding));
  AddPart(text, "The best within a time", ForceNote(), EqualTimeTable(study, holding));
  AddPart(text, "The cheapest within an error", ForceNote(), EqualErrorTable(study, holding));
  AddPart(text, "Voxels against the slab", ForceNote(), SlabTable(study, holding));
  AddPart(text, "Orders", "The slope of log error against log number; a positive one falls as the number does.",
          OrdersTable(study, holding));
  AddFigures(text, figures, holding, true);
  AddPart(text, "All settings", ForceNote(), SettingsTable(study, holding));
}

std::string FormatReport(const StudyResults& study, const std::vector<StudyFigure>& figures) {
  std::string text = fmt::format("# {}\n\n", EscapeMarkdown(study.title.empty() ? study.name : study.title));
  Add(text, "Written by `kerf study`. What each figure means: docs/accuracy.md of kerf.\n\n");
  if (const std::string base = DescribeBase(study.base); !base.empty()) {
    Add(text, "\"The defaults\" are here the study's base settings, which differ from what kerf ships: {}.\n\n", base);
  }
  const std::vector<Holding> holdings = HoldingsOf(study);
  if (holdings.empty()) Add(text, "No case was done, so there is nothing to show.\n\n");
  for (const Holding holding : holdings) {
    Add(text, "## Found: {}\n\n{}", DescribeHolding(holding), DescribeFindings(study, holding));
  }
  if (!holdings.empty()) {
    Add(text,
        "Errors are those of `force_p95`: of |F - R| / max(|R|, 0.5 N) the 95th percentile over a path's ticks, R the "
        "reference. Of a setting, the error is that of its worst path and the time that of its slowest, so that no "
        "figure "
        "is better than what a user may meet. Times are for a millisecond of simulated time: of 2000 ticks a second, "
        "two, of 500 half of one. "
        "Differences of less than 3 % in error and 5 % in time count as none.\n\n");
  }
  for (const Holding holding : holdings) AddHolding(text, study, holding, figures);
  Add(text, "## Left out and failed\n\n{}", LeftOutTable(study));
  const std::string references = ReferencesTable(study);
  if (!references.empty()) {
    Add(text,
        "## References\n\nThe error bar is the difference between the last two refinements. An error that is smaller "
        "is "
        "given as \"at most\" the bar.\n\n{}",
        references);
  }
  Add(text, "## Paths\n\n");
  for (const std::string& path : study.paths) {
    const auto title = study.path_titles.find(path);
    Add(text, "- `{}`: {}\n", path, title != study.path_titles.end() ? EscapeMarkdown(title->second) : "");
  }
  Add(text, "\n## To make it again\n\n```\n{}\n```\n\n", MarkdownCodeLine(study.command));
  Add(text, "The figures and this report from the tables alone: `kerf study --redraw FOLDER`.\n\n");
  Add(text, "Commit {}, {}. Measured on {}, {} cores for this program, load {:.2f}; {:.0f} s of work.\n", study.commit,
      study.build, study.machine.cpu, study.machine.cores, study.machine.load, study.seconds);
  return text;
}

}  // namespace

void WriteStudyReport(const StudyResults& study, const std::string& folder,
                      const std::function<void(const std::string&)>& progress) {
  const std::vector<std::string> earlier = ReadEarlierResults(folder, "study.json");
  std::vector<std::string> files;
  const auto write = [&](const std::string& name, const std::string& text) {
    WriteTextFile(folder + "/" + name, text);
    files.push_back(name);
  };
  if (progress) progress("tables");
  write("cases.csv", FormatCasesCsv(study));
  write("cases_times.csv", FormatTimesCsv(study));
  write("references.csv", FormatReferencesCsv(study));
  const std::vector<StudyFigure> figures = MakeStudyFigures(study);
  for (const StudyFigure& figure : figures) {
    if (progress) progress(fmt::format("figure {}", figure.name));
    write(figure.name + ".svg", FormatPlotSvg(figure.plot));
    WritePlot(figure.plot, folder + "/" + figure.name + ".png");
    files.push_back(figure.name + ".png");
  }
  write("report.md", FormatReport(study, figures));
  // Last, since it tells what the folder has.
  WriteTextFile(folder + "/study.json", FormatStudyJson(study, files));
  RemoveStaleResults(folder, earlier, files);
}

}  // namespace kerf
