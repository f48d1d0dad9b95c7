// Segmentations in DICOM files.
#pragma once

#include <string>

#include "bone/segmentation/segmentation.h"

namespace kerf {

/// Reads a DICOM segmentation (dicom_segments.h). Segments that overlap get layers of their own. Throws kerf::Error
/// with one sentence if the file cannot be read, if its slices are not evenly spaced along their normal, or if it has
/// more than kMaxSegments segments.
Segmentation ReadDicomSegmentation(const std::string& path);

}  // namespace kerf
