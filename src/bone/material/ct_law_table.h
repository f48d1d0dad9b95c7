// Laws from CT number to modulus in CSV format, and the laws built into kerf.
#pragma once

#include <string>
#include <vector>

#include "kerf/material.h"

namespace kerf {

/// Parses CSV with the header `name,tissue,density,calibration,bands,tag,source` (docs/formats.md). `file` names the
/// text in messages. Throws kerf::Error with file:line for the first fault.
std::vector<CtLaw> ParseCtLaws(const std::string& text, const std::string& file);
std::string FormatCtLaws(const std::vector<CtLaw>& laws);

/// Parses points such as `HU:density HU:density ...`, density in g/cm3. Throws kerf::Error if they are invalid.
std::vector<CtLaw::Point> ParseCalibration(const std::string& text);
std::string FormatCalibration(const std::vector<CtLaw::Point>& points);

/// Returns volumes/ct_laws.csv, which is built in.
const std::vector<CtLaw>& DefaultCtLaws();

/// Returns the law with the given name. Throws kerf::Error if there is none. The message names the law with the most
/// similar name, or all laws if none is similar.
const CtLaw& FindCtLaw(const std::vector<CtLaw>& laws, const std::string& name);

/// Returns the law with its own calibration or, if not empty, with `calibration`. Throws kerf::Error if there is no
/// calibration or it does not fit the law.
CtLaw WithCalibration(CtLaw law, const std::string& calibration);

}  // namespace kerf
