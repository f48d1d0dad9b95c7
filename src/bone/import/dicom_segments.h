// DICOM segmentations (PS3.3 A.51).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Classes of a segmentation: with frames for each segment, and with a label in each pixel.
inline constexpr const char* kSegmentationStorage = "1.2.840.10008.5.1.4.1.1.66.4";
inline constexpr const char* kLabelMapStorage = "1.2.840.10008.5.1.4.1.1.66.7";

/// Fraction of the range of a fractional segmentation from which on a voxel counts.
inline constexpr double kHalfFraction = 0.5;

/// A segment as its file describes it.
struct DicomSegment {
  int number = 0;  // 1 to 65535
  std::string label;
  std::string category;                // SNOMED CT code of its category; empty: none
  std::vector<std::string> codes;      // SNOMED CT codes of its type
  std::vector<std::string> modifiers;  // SNOMED CT codes of the type's modifiers
};

/// One slice of one segment, or of a label map.
struct DicomSegmentFrame {
  int segment = 0;   // number of its segment; 0 in a label map
  Vec3 origin_W{0};  // centre of its first pixel, LPS, mm
};

struct DicomSegments {
  std::string series_uid;  // of the images that were segmented; empty: not stated
  std::string frame_uid;   // of the frame of reference; empty: not stated
  std::array<int, 2> size{0, 0};
  std::array<double, 2> pixel_mm{0, 0};  // along a row, and from row to row
  double slice_mm = 0;                   // as stated; 0: not stated
  Vec3 row_W{0};                         // unit vector along a row
  Vec3 column_W{0};
  std::vector<DicomSegment> segments;
  std::vector<DicomSegmentFrame> frames;
  std::vector<std::uint8_t> pixels;   // of all frames, row by row: 1 in the segment; none in a label map
  std::vector<std::uint16_t> labels;  // the same of a label map: numbers of segments, 0 for none
  std::vector<std::string> warnings;  // one sentence each
};

/// Returns whether the file begins like a DICOM file (BeginsLikeDicom()). Throws kerf::Error as OpenImageFile() does.
bool IsDicomFile(const std::string& path);

/// Returns whether the file is a DICOM segmentation. Throws kerf::Error as OpenImageFile() does.
bool IsDicomSegmentation(const std::string& path);

/// Reads a segmentation with the type BINARY, LABELMAP or FRACTIONAL, whose voxels count from the fraction `threshold`
/// of their range on. The whole data set may be deflated, and the pixels compressed as GDCM reads them. Throws
/// kerf::Error with one sentence if the file is not a DICOM segmentation of slices, is damaged, is larger than 2 GiB or
/// unpacks to more, or contradicts itself.
DicomSegments ReadDicomSegments(const std::string& path, double threshold = kHalfFraction);

}  // namespace kerf
