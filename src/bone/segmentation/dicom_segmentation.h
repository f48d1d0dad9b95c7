// Segmentations in DICOM files.
#pragma once

#include <string>

#include "bone/segmentation/segmentation.h"

namespace kerf {

/// Reads a DICOM segmentation (dicom_segments.h); `threshold`: fraction of the range of a fractional segmentation from
/// which on a voxel counts. Segments that overlap get layers of their own. Slices may be sheared, as those of a tilted
/// gantry, and in any order; a segment with a frame at every second slice fills those between. Throws kerf::Error with
/// one sentence if the file cannot be read, if its slices are farther than a quarter of their distance from even
/// spacing, or if it has more than kMaxSegments segments.
Segmentation ReadDicomSegmentation(const std::string& path, double threshold = 0.5);

}  // namespace kerf
