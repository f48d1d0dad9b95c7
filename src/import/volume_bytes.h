// What a child process reads, as bytes for the process that asked (files/child.h).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "import/dicom.h"
#include "import/volume.h"

namespace kerf {

std::string Encode(const Volume& volume);
std::string Encode(const std::vector<DicomSeries>& all);
/// Of bytes that Encode() made. Throw Error for others.
Volume DecodeVolume(std::string_view bytes);
std::vector<DicomSeries> DecodeSeries(std::string_view bytes);

}  // namespace kerf
