// DICOM segmentations (PS3.3 A.51).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "kerf/geometry.h"

namespace kerf {

/// Class of a segmentation.
inline constexpr const char* kSegmentationStorage = "1.2.840.10008.5.1.4.1.1.66.4";

/// A segment as its file describes it.
struct DicomSegment {
  int number = 0;  // 1 to 65535
  std::string label;
  std::string category;                // SNOMED CT code of its category; empty: none
  std::vector<std::string> codes;      // SNOMED CT codes of its type
  std::vector<std::string> modifiers;  // SNOMED CT codes of the type's modifiers
};

/// One slice of one segment.
struct DicomSegmentFrame {
  int segment = 0;   // number of its segment
  Vec3 origin_W{0};  // centre of its first pixel, LPS, mm
};

struct DicomSegments {
  std::string series_uid;  // of the images that were segmented; empty: not stated
  std::array<int, 2> size{0, 0};
  std::array<double, 2> pixel_mm{0, 0};  // along a row, and from row to row
  double slice_mm = 0;                   // as stated; 0: not stated
  Vec3 row_W{0};                         // unit vector along a row
  Vec3 column_W{0};
  std::vector<DicomSegment> segments;
  std::vector<DicomSegmentFrame> frames;
  std::vector<std::uint8_t> pixels;  // of all frames, row by row: 1 in the segment
};

/// Returns whether the file begins like a DICOM file (BeginsLikeDicom()). Throws kerf::Error as OpenImageFile() does.
bool IsDicomFile(const std::string& path);

/// Returns whether the file is a DICOM segmentation. Throws kerf::Error as OpenImageFile() does.
bool IsDicomSegmentation(const std::string& path);

/// Reads a segmentation with the type BINARY or FRACTIONAL, whose voxels count from half of their range on. Throws
/// kerf::Error with one sentence if the file is not a DICOM segmentation, is compressed, damaged or larger than 2 GiB,
/// or contradicts itself.
DicomSegments ReadDicomSegments(const std::string& path);

}  // namespace kerf
