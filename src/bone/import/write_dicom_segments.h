// Writing of DICOM segmentations (PS3.3 A.51).
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bone/import/dicom_segments.h"
#include "bone/import/dicom_study.h"

namespace kerf {

struct DicomCode {
  std::string value;
  std::string scheme;  // "SCT" for SNOMED CT
  std::string meaning;
};

struct DicomWrittenSegment {
  std::string label;
  DicomCode category, type;
  std::array<std::uint8_t, 3> colour{};  // sRGB
};

/// Binary segments on cubes along the patient's axes, LPS.
struct DicomWriting {
  std::array<int, 2> size{0, 0};  // columns, rows
  double voxel_mm = 0;
  std::vector<DicomWrittenSegment> segments;  // with the numbers 1, 2, ...
  std::vector<DicomSegmentFrame> frames;
  std::vector<std::uint8_t> pixels;  // of all frames, row by row, 8 pixels a byte, the first in the lowest bit
};

/// Writes a segmentation of the CT that `study` describes, through a temporary file. Throws kerf::Error if the file
/// cannot be written, or would be larger than kerf reads.
void WriteDicomSegments(const DicomWriting& writing, const DicomStudy& study, const std::string& path);

}  // namespace kerf
