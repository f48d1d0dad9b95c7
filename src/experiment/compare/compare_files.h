// A comparison as files: report, table, JSON and figures.
#pragma once

#include <string>
#include <vector>

#include "base/table/table.h"
#include "experiment/compare/comparison.h"
#include "view/plot/plot.h"

namespace kerf {

/// docs/compare.md describes each part, column and key.
std::string FormatCompareReport(const Comparison& comparison);
/// Describes the columns of compare.csv, whose rows are the steps of the depth. Refers to `comparison`.
Columns<std::size_t> CompareColumns(const Comparison& comparison);
std::string FormatCompareCsv(const Comparison& comparison);
std::string FormatCompareJson(const Comparison& comparison);

PlotSpec MakeForceDepthPlot(const Comparison& comparison);
PlotSpec MakeDifferencePlot(const Comparison& comparison);
PlotSpec MakeCostPlot(const Comparison& comparison);

/// Throws Error if a result in `folder` would overwrite one of the inputs: the scene, or a file that it refers to.
void CheckCompareInputsNotOverwritten(const Scene& scene, const std::string& scene_file, const std::string& folder);

/// Writes report.md, compare.csv, compare.json, force_depth.png, difference.png and cost.png into `folder` (created if
/// missing). Each file is written completely or not at all, compare.json last. Returns their names. Throws Error if a
/// file cannot be written.
std::vector<std::string> WriteComparison(const Comparison& comparison, const std::string& folder);

}  // namespace kerf
