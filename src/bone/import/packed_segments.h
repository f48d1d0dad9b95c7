// A DICOM segmentation on its way from the child process that reads it to kerf.
#pragma once

#include <span>
#include <string>

#include "bone/import/dicom_segments.h"

namespace kerf {

/// Reads the segmentation at `path` with GDCM, which may end the process if the file is damaged: for a child process.
/// Copies the bytes of its pixels, as many as there is room for, and returns everything else as one text. Throws
/// kerf::Error as ReadDicomSegments() does. The header must have been checked (dicom_header.h).
std::string PackSegments(const std::string& path, std::span<char> pixels);

/// Returns the segmentation from what PackSegments() returned and the bytes that it copied. Throws kerf::Error with one
/// sentence if they contradict themselves, are incomplete, or were not made by PackSegments(). `path` names the file in
/// messages.
DicomSegments UnpackSegments(const std::string& packed, std::span<const char> pixels, const std::string& path);

}  // namespace kerf
