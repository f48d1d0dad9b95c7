#include "experiment/study/study_report.h"

#include <fmt/format.h>

#include <iterator>
#include <set>

#include "base/core/append_format.h"
#include "base/files/files.h"
#include "base/files/markdown_text.h"
#include "cut/force/measured.h"
#include "experiment/study/figures.h"
#include "experiment/study/study_words.h"
#include "session/run/results_folder.h"

namespace kerf {
namespace {

void AddPart(std::string& text, const char* heading, const std::string& words, const std::string& table) {
  if (table.empty()) return;
  AppendFormat(text, "### {}\n\n{}{}{}", heading, words, words.empty() ? "" : "\n\n", table);
}

/// Returns the text below the heading of each table of force errors.
std::string ForceNote() {
  return fmt::format(
      "Force, p95: 95th percentile of |F - R| / max(|R|, {0:g} N); smaller reference forces count as {0:g} N.",
      kMinForce_N);
}
constexpr const char* kImpulseNote =
    " Impulse: (integral of |F| - integral of |R|) / integral of |R| over the path; positive if the force is too large "
    "overall, negative if too small, empty if the version that ran this case did not record it.";

void AddFigures(std::string& text, const std::vector<StudyFigure>& figures, Holding holding, bool convergence) {
  const std::string ending = fmt::format("_{}", ToString(holding));
  for (const StudyFigure& figure : figures) {
    const bool one_knob = figure.name.starts_with("convergence_") || figure.name.starts_with("volume_") ||
                          figure.name.starts_with("surface_");
    if (!figure.name.ends_with(ending) || one_knob != convergence) continue;
    AppendFormat(text, "![{}]({}.png)\n\n{} [SVG]({}.svg)\n\n", figure.plot.title, figure.name, figure.caption,
                 figure.name);
  }
}

void AddHolding(std::string& text, const StudyResults& study, Holding holding,
                const std::vector<StudyFigure>& figures) {
  AppendFormat(text, "## The {}\n\n", DescribeHolding(holding));
  AddFigures(text, figures, holding, false);
  AddPart(text, "The defaults, path by path", ForceNote() + kImpulseNote, DefaultsTable(study, holding));
  AddPart(text, "The best within a time limit", ForceNote(), EqualTimeTable(study, holding));
  AddPart(text, "The cheapest within an error limit", ForceNote(), EqualErrorTable(study, holding));
  AddPart(text, "Voxels against the slab", ForceNote(), SlabTable(study, holding));
  AddPart(text, "Orders",
          "The slope of log error against log value; if it is positive, a smaller value gives a smaller error. In "
          "brackets: its 95 % interval over the paths, if there are at least three.",
          OrdersTable(study, holding));
  AddFigures(text, figures, holding, true);
  AddPart(text, "All settings", ForceNote(), SettingsTable(study, holding));
}

std::string FormatReport(const StudyResults& study, const std::vector<StudyFigure>& figures) {
  std::string text = fmt::format("# {}\n\n", EscapeMarkdown(study.title.empty() ? study.name : study.title));
  AppendFormat(text, "Written by `kerf study`. docs/accuracy.md of kerf explains each figure.\n\n");
  if (const std::string base = DescribeBase(study.base); !base.empty()) {
    AppendFormat(
        text, "Here \"the defaults\" are the study's base settings, which differ from kerf's defaults: {}.\n\n", base);
  }
  const std::vector<Holding> holdings = HoldingsOf(study);
  if (holdings.empty()) AppendFormat(text, "No case was run, so there is nothing to show.\n\n");
  for (const Holding holding : holdings) {
    AppendFormat(text, "## Findings: {}\n\n{}", DescribeHolding(holding), DescribeFindings(study, holding));
  }
  if (!holdings.empty()) {
    AppendFormat(
        text,
        "Errors are those of `force_p95`: the 95th percentile of |F - R| / max(|R|, 0.5 N) over a path's ticks, where "
        "R is the reference. The error of a setting is that of its worst path and its time is that of its slowest "
        "path, so that no figure is better than what a user may experience. Times are per millisecond of simulated "
        "time: two ticks at 2000 ticks per second, half a tick at 500. Differences of less than 3 % in error and 5 % "
        "in time are ignored.\n\n"
        "All of these are errors of the numerics. The laws themselves are this far from measured bone:\n\n");
    std::set<std::string> laws{study.base.law};
    for (const CaseRecord& record : study.cases) {
      if (record.knob == "law") laws.insert(record.value);
    }
    for (const std::string& law : laws) {
      AppendFormat(text, "- {}: {}\n", law, DescribeAccuracy(ForceLaw(law), DiscSaw{}));
    }
    text += '\n';
  }
  for (const Holding holding : holdings) AddHolding(text, study, holding, figures);
  AppendFormat(text, "## Left out and failed\n\n{}", LeftOutTable(study));
  const std::string references = ReferencesTable(study);
  if (!references.empty()) {
    AppendFormat(
        text,
        "## References\n\nThe error bar is the difference between the last two refinements. A smaller error is given "
        "as \"at most\" the error bar, or at most {}.\n\n{}",
        ShowFraction(kFinestError), references);
  }
  AppendFormat(text, "## Paths\n\n");
  for (const std::string& path : study.paths) {
    const auto title = study.path_titles.find(path);
    AppendFormat(text, "- `{}`: {}\n", path, title != study.path_titles.end() ? EscapeMarkdown(title->second) : "");
  }
  AppendFormat(text, "\n## To reproduce\n\n```\n{}\n```\n\n", MarkdownCodeLine(study.command));
  AppendFormat(text,
               "To regenerate the figures and this report from the tables alone: `kerf study --redraw FOLDER`.\n\n");
  AppendFormat(text, "Commit {}, {}. Measured on {}, {} cores available, load {:.2f}; {:.0f} s of computation.\n",
               study.commit, study.build, study.machine.cpu, study.machine.cores, study.machine.load, study.seconds);
  return text;
}

}  // namespace

void WriteStudyReport(const StudyResults& study, const std::string& folder,
                      const std::function<void(const std::string&)>& progress) {
  const std::vector<std::string> earlier = ReadEarlierResults(folder, "study.json");
  FileBatch results(folder, "study.json");
  std::vector<std::string> files;
  const auto write = [&](const std::string& name, const std::string& text) {
    WriteTextFile(folder + "/" + name, text);
    files.push_back(name);
  };
  if (progress) progress("tables");
  write("cases.csv", FormatCsv(CaseColumns(), study.cases));
  write("cases_times.csv", FormatCsv(BucketColumns(), ListBuckets(study)));
  write("references.csv", FormatCsv(ReferenceColumns(), study.references));
  const std::vector<StudyFigure> figures = MakeStudyFigures(study);
  for (const StudyFigure& figure : figures) {
    if (progress) progress(fmt::format("figure {}", figure.name));
    write(figure.name + ".svg", FormatPlotSvg(figure.plot));
    WritePlot(figure.plot, folder + "/" + figure.name + ".png");
    files.push_back(figure.name + ".png");
  }
  write("report.md", FormatReport(study, figures));
  // This file is written last, since it lists the contents of the folder.
  WriteTextFile(folder + "/study.json", FormatStudyJson(study, files));
  results.Commit(earlier);
}

}  // namespace kerf
