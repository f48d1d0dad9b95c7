// The list of DICOM series as bytes, for the process that asked a child for it (files/child.h).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

std::string Encode(const std::vector<DicomSeries>& all);
/// Of bytes that Encode() made. Throws Error for others.
std::vector<DicomSeries> DecodeSeries(std::string_view bytes);

}  // namespace kerf
