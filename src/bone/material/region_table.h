// The region table as text: CSV with a header, and the table that kerf ships.
#pragma once

#include <string>

#include "kerf/material.h"

namespace kerf {

/// CSV with the header `id,name,tissue,E_GPa,nu,estimate,source`; '#' starts a comment line; a field with a comma
/// stands in double quotes. `file` names the text in messages. Throws Error with file:line for the first fault.
MaterialTable ParseRegionTable(const std::string& text, const std::string& file);
std::string FormatRegionTable(const MaterialTable& table);

/// volumes/mandible_regions.csv, built in: regions 1-31 the cortex after Schwartz-Dabney and Dechow (four rows from the
/// paper, the others estimates), and the ids below.
const MaterialTable& DefaultMandibleTable();
inline constexpr int kCancellousRegion = 32;
inline constexpr int kToothRegion = 33;
inline constexpr int kCanalRegion = 34;

}  // namespace kerf
