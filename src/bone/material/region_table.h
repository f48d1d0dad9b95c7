// The region table in CSV format, and the table built into kerf.
#pragma once

#include <string>

#include "kerf/material.h"

namespace kerf {

/// Parses CSV with the header `id,name,tissue,E_GPa,nu,estimate,source` and, optionally, the columns `E_lower_GPa` and
/// `E_upper_GPa`: both are empty, or they enclose E. '#' starts a comment line; a field with a
/// comma is in double quotes. `file` names the text in messages. Throws kerf::Error with file:line for the first fault.
MaterialTable ParseRegionTable(const std::string& text, const std::string& file);
/// Writes the columns of the interval only if a region has one.
std::string FormatRegionTable(const MaterialTable& table);

/// Returns volumes/mandible_regions.csv, which is built in: regions 1 to 31, the cortex after Schwartz-Dabney and
/// Dechow (four rows from the paper, the others estimates), and the regions below.
const MaterialTable& DefaultMandibleTable();
/// Largest E of a table, MPa: ten times that of diamond; a larger value means a wrong unit.
inline constexpr double kMaxTableE_MPa = 1e7;
inline constexpr int kCancellousRegion = 32;
inline constexpr int kToothRegion = 33;
inline constexpr int kCanalRegion = 34;

}  // namespace kerf
