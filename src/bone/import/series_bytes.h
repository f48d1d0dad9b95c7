// Serialisation of the list of DICOM series, for the transfer from a child process to its parent (files/child.h).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

std::string Encode(const std::vector<DicomSeries>& all);
/// Decodes the result of Encode(). Throws kerf::Error if `bytes` is anything else.
std::vector<DicomSeries> DecodeSeries(std::string_view bytes);

}  // namespace kerf
