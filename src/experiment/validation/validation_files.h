// A comparison with measurements as files: report, tables, JSON and figures.
#pragma once

#include <string>
#include <vector>

#include "base/table/table.h"
#include "experiment/validation/validation.h"
#include "view/plot/plot.h"

namespace kerf {

/// Columns of values.csv, trends.csv, teeth.csv and blades.csv. Each refers to `v`.
Columns<ValueComparison> ValueColumns(const Validation& v);
Columns<TrendComparison> TrendColumns(const Validation& v);
Columns<ToothCheck> ToothColumns(const Validation& v);
Columns<BladeCheck> BladeColumns(const Validation& v);

struct ValidationFigure {
  std::string name;     // of its file, without extension
  std::string caption;  // what it shows, for the report
  PlotSpec plot;
};
/// Returns a figure for each quantity of teeth of one width, against the bite, and for each quantity of each drill,
/// against its speed. Quantities of which no value is known, or that no law has, are left out.
std::vector<ValidationFigure> MakeValidationFigures(const Validation& v);

/// Returns the report in Markdown.
std::string FormatValidationReport(const Validation& v);
std::string FormatValidationJson(const Validation& v);

/// Throws Error if WriteValidation() would replace one of `inputs`.
void CheckValidationInputsNotOverwritten(const std::vector<std::string>& inputs, const std::string& folder);

/// Writes report.md, values.csv, trends.csv, teeth.csv, blades.csv, the figures and validate.json into `folder`
/// (created if missing). Each file is written completely or not at all, validate.json last. Returns their names. Throws
/// Error if a file cannot be written.
std::vector<std::string> WriteValidation(const Validation& v, const std::string& folder);

}  // namespace kerf
