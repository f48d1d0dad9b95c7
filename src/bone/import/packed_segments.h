// A DICOM segmentation on its way from the child process that reads it to kerf.
#pragma once

#include <istream>
#include <span>
#include <string>

#include "bone/import/dicom_segments.h"

namespace kerf {

/// How the pixels of the file are stored.
enum class SegmentPacking {
  kNative,          // as they are
  kCompressed,      // each frame, as GDCM reads it
  kDeflatedFrames,  // each frame, with zlib (PS3.5 A.4.13); the file states another syntax, which GDCM knows
};

/// Reads the segmentation in `in` with GDCM, which may end the process if the file is damaged: for a child process.
/// Copies the bytes of its pixels, unpacked, as many as there is room for, and returns everything else as one text.
/// Throws kerf::Error as ReadDicomSegments() does. The header must have been checked (dicom_header.h). `path` names the
/// file in messages.
std::string PackSegments(std::istream& in, SegmentPacking packing, std::span<char> pixels, const std::string& path);

/// Returns the segmentation from what PackSegments() returned and the bytes that it copied; `threshold` as in
/// ReadDicomSegments(). Throws kerf::Error with one sentence if they contradict themselves, are incomplete, or were not
/// made by PackSegments().
DicomSegments UnpackSegments(const std::string& packed, std::span<const char> pixels, double threshold,
                             const std::string& path);

}  // namespace kerf
