// Result files of `kerf stability`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/table/table.h"
#include "experiment/stability_study/stability.h"
#include "session/scene/scene.h"
#include "view/plot/plot.h"

namespace kerf {

/// Formats the study as JSON. The keys name the units and stay the same from version to version.
std::string FormatStabilityJson(const StabilityStudy& study);

/// A row of figures.csv. A scenario in which the tool cut through has an additional row "cut through" of the kind
/// "when".
struct FigureRow {
  std::string scenario;
  std::string figure;
  std::string unit;
  double value = 0;
  std::string kind;
  std::optional<double> bound;
  std::string holds;
};
const Columns<FigureRow>& FigureColumns();
std::vector<FigureRow> ListFigures(const StabilityStudy& study);
const Columns<HandMargins>& MarginColumns();  // of margins.csv
std::vector<HandMargins> ListMargins(const StabilityStudy& study);
/// Describes the columns of map.csv, whose rows are the points of the map. Refers to `study`.
Columns<std::size_t> MapColumns(const StabilityStudy& study);
std::string FormatMapCsv(const StabilityStudy& study);

/// Formats the report for the user, in Markdown.
std::string FormatStabilityReport(const StabilityStudy& study);

/// "Stable" or "Not stable", and the number of checks that this is based on, or that the examination was ended early.
std::string DescribeVerdict(const StabilityStudy& study);
/// Describes the worst figure in words; empty if there is none.
std::string DescribeWorst(const StabilityStudy& study);
/// "12.5 mN, at most 20", with a mark if the bound is violated.
std::string DescribeFigure(const StabilityFigure& figure);
/// "cut through at t = 1.25 s"; empty for a scenario in which the tool did not come out behind the bone.
std::string DescribeCutThrough(const ScenarioResult& scenario);
/// Combines two judgements that share one line: broken if one is broken, otherwise not judged if one is not judged.
Judgement Both(Judgement a, Judgement b);
/// "> 64 / 16": gain and whole ticks of delay; or the reason why they are unknown.
std::string DescribeMargins(const Margins& margins);

PlotSpec MakeMapPlot(const StabilityStudy& study);
enum class MarginKind { kGain, kDelay };
PlotSpec MakeMarginPlot(const StabilityStudy& study, MarginKind kind);
/// Plots the force of a scenario over time.
PlotSpec MakeScenarioPlot(const StabilityStudy& study, const WorstFigure& worst);

/// Writes report.md, stability.json, figures.csv, margins.csv, map.csv, map.png, margins.png, delays.png, worst_N.png
/// and scene.toml (resolved) into `folder`, which is created if missing. Replaces or removes the results of an earlier
/// study in the same folder. Fills `study.files`.
void WriteStabilityStudy(const Scene& scene, StabilityStudy& study, const std::string& folder);
/// Throws Error if one of the files would overwrite one of the scene's own inputs.
void CheckStabilityInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder);

/// Formats a Markdown table with one row for each device and one column for each hand. Each cell contains the minimum
/// over the states.
std::string FormatProfilesTable(const std::vector<ProfileMargins>& rows);
/// `complete` is false if the examination was ended before all devices and hands were examined.
std::string FormatProfilesJson(const Scene& scene, const std::vector<ProfileMargins>& rows, bool complete = true);

}  // namespace kerf
