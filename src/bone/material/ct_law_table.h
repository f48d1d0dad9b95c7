// The laws from CT number to modulus as text: CSV with a header, and those that kerf ships.
#pragma once

#include <string>
#include <vector>

#include "kerf/material.h"

namespace kerf {

/// CSV with the header `name,tissue,density,calibration,bands,tag,source` (docs/formats.md). `file` names the text in
/// messages. Throws Error with file:line for the first fault.
std::vector<CtLaw> ParseCtLaws(const std::string& text, const std::string& file);
std::string FormatCtLaws(const std::vector<CtLaw>& laws);

/// Points as `HU:density HU:density ...`, density in g/cm3. Throws Error.
std::vector<CtLaw::Point> ParseCalibration(const std::string& text);
std::string FormatCalibration(const std::vector<CtLaw::Point>& points);

/// volumes/ct_laws.csv, built in.
const std::vector<CtLaw>& DefaultCtLaws();

/// Throws Error that names the nearest when there is none of that name, or all when none is near.
const CtLaw& FindCtLaw(const std::vector<CtLaw>& laws, const std::string& name);

/// The law with its own calibration, or with the one given. Throws Error when there is none, or they don't fit
/// together.
CtLaw WithCalibration(CtLaw law, const std::string& calibration);

}  // namespace kerf
