// An uncertain run as files: table, JSON, report and figure.
#pragma once

#include <string>
#include <vector>

#include "experiment/uncertainty/band.h"
#include "experiment/uncertainty/uncertain.h"
#include "view/plot/plot.h"

namespace kerf {

/// docs/uncertainty.md describes each part, column and key.
std::string FormatBandCsv(const UncertainResult& result);
std::string FormatUncertainJson(const UncertainRun& run, const UncertainResult& result);
std::string FormatUncertainReport(const UncertainRun& run, const UncertainResult& result, bool has_figure);
/// Force against travel or, if the path has several strokes, against time.
PlotSpec MakeBandPlot(const UncertainRun& run, const UncertainResult& result);

/// Returns the lines of the result for a terminal.
std::string DescribeUncertain(const UncertainRun& run, const UncertainResult& result);

/// Throws kerf::Error if a result in `folder` would overwrite the scene or a file that it refers to.
void CheckUncertainInputsNotOverwritten(const std::vector<std::string>& inputs, const std::string& folder);

/// Writes band.csv, report.md, band.png (if `pictures`) and uncertain.json into `folder` (created if missing). Each
/// file is written completely or not at all, uncertain.json last. Returns their names. Throws kerf::Error if a file
/// cannot be written.
std::vector<std::string> WriteUncertain(const UncertainRun& run, const UncertainResult& result,
                                        const std::string& folder, bool pictures);

}  // namespace kerf
