// A comparison as files: report, table, JSON and figures.
#pragma once

#include <string>
#include <vector>

#include "experiment/compare/comparison.h"
#include "view/plot/plot.h"

namespace kerf {

/// docs/compare.md says what each part, column and key is.
std::string FormatCompareReport(const Comparison& comparison);
std::string FormatCompareCsv(const Comparison& comparison);
std::string FormatCompareJson(const Comparison& comparison);

PlotSpec MakeForceDepthPlot(const Comparison& comparison);
PlotSpec MakeDifferencePlot(const Comparison& comparison);
PlotSpec MakeCostPlot(const Comparison& comparison);

/// Throws Error when a result in `folder` would replace one of the inputs: the scene, or what it names.
void CheckCompareInputsStay(const Scene& scene, const std::string& scene_file, const std::string& folder);

/// Writes report.md, compare.csv, compare.json, force_depth.png, difference.png and cost.png into `folder` (made when
/// missing), each whole or not at all, compare.json last. Returns their names. Throws Error.
std::vector<std::string> WriteComparison(const Comparison& comparison, const std::string& folder);

}  // namespace kerf
