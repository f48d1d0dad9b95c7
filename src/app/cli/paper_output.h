// What kerf paper prints: for people, for programs and for the README.
#pragma once

#include <string>

#include "cut/paper/paper_tables.h"

namespace kerf::cli {

std::string FormatPaperText(const PaperTables& tables);
/// One object; keys with units.
std::string FormatPaperJson(const PaperTables& tables);
/// A row for each of the 24 forces.
std::string FormatPaperCsv(const PaperTables& tables);
/// The block of the README, between the lines <!-- kerf paper --markdown --> and <!-- end -->.
std::string FormatPaperMarkdown(const PaperTables& tables);

}  // namespace kerf::cli
