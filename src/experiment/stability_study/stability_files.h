// What `kerf stability` leaves behind.
#pragma once

#include <string>
#include <vector>

#include "experiment/stability_study/stability.h"
#include "session/scene/scene.h"
#include "view/plot/plot.h"

namespace kerf {

/// Stable keys with units.
std::string FormatStabilityJson(const StabilityStudy& study);
/// scenario,figure,unit,value,kind,bound,holds; a row "cut through" (kind "when") where the tool cut through.
std::string FormatFiguresCsv(const StabilityStudy& study);
std::string FormatMarginsCsv(const StabilityStudy& study);
/// A row a point of the map; in the simulation's units and the device's.
std::string FormatMapCsv(const StabilityStudy& study);
/// For people, Markdown.
std::string FormatStabilityReport(const StabilityStudy& study);

/// "Stable", "Not stable", of how much, or that it was ended before.
std::string DescribeVerdict(const StabilityStudy& study);
/// The worst figure in words; "" when there is none.
std::string DescribeWorst(const StabilityStudy& study);
/// "12.5 mN, at most 20" with a mark where it does not hold.
std::string DescribeFigure(const StabilityFigure& figure);
/// "cut through at t = 1.25 s"; "" for a scenario in which the tool did not come out behind the bone.
std::string DescribeCutThrough(const ScenarioResult& scenario);
/// Of two that stand in one line: broken if one is, else not judged if one is not.
Judgement Both(Judgement a, Judgement b);
/// "> 64 / 16" : gain and whole ticks of delay; or why they can't be told.
std::string DescribeMargins(const Margins& margins);

PlotSpec MakeMapPlot(const StabilityStudy& study);
enum class MarginKind { kGain, kDelay };
PlotSpec MakeMarginPlot(const StabilityStudy& study, MarginKind kind);
/// The force of a scenario over time.
PlotSpec MakeScenarioPlot(const StabilityStudy& study, const WorstFigure& worst);

/// report.md, stability.json, figures.csv, margins.csv, map.csv, map.png, margins.png, delays.png, worst_N.png and
/// scene.toml (resolved) in `folder`, made when missing. Results of an earlier study in the same folder are replaced or
/// removed. Fills `study.files`.
void WriteStabilityStudy(const Scene& scene, StabilityStudy& study, const std::string& folder);
/// Throws Error when one of them would replace one of the scene's own inputs.
void CheckStabilityInputsStay(const Scene& scene, const std::string& scene_file, const std::string& folder);

/// Markdown: a row a device, a column a hand, the least of the states in each.
std::string FormatProfilesTable(const std::vector<ProfileMargins>& rows);
/// `complete`: false when it was ended before all were examined.
std::string FormatProfilesJson(const Scene& scene, const std::vector<ProfileMargins>& rows, bool complete = true);

}  // namespace kerf
