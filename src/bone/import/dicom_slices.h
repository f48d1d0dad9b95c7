// The slices of a DICOM file, as its header describes them.
#pragma once

#include <gdcmReader.h>
#include <gdcmStringFilter.h>

#include <string>
#include <vector>

#include "bone/import/dicom.h"

namespace kerf {

/// Returns the slices of an image file. `filter`: of the file that `reader` has read up to its pixels; `path` is used
/// in messages. Throws kerf::Error if a slice has more pixels than kerf reads.
std::vector<DicomSlice> ListSlices(const gdcm::Reader& reader, gdcm::StringFilter& filter, const std::string& path);

}  // namespace kerf
