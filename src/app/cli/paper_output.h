// Output formats of kerf paper: human-readable text, JSON, CSV, and Markdown for docs/paper.md.
#pragma once

#include <string>

#include "cut/paper/paper_tables.h"

namespace kerf::cli {

std::string FormatPaperText(const PaperTables& tables);
/// Formats one JSON object, whose keys include the units.
std::string FormatPaperJson(const PaperTables& tables);
/// Formats CSV with one row for each of the 24 forces.
std::string FormatPaperCsv(const PaperTables& tables);
/// Formats the block of docs/paper.md between the lines <!-- kerf paper --markdown --> and <!-- end -->.
std::string FormatPaperMarkdown(const PaperTables& tables);

}  // namespace kerf::cli
