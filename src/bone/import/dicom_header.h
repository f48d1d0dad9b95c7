// The elements of a DICOM file held against the bytes that are there, before GDCM is let at it.
#pragma once

#include <istream>
#include <string>

namespace kerf {

/// Throws Error with one sentence when the DICOM file at `path` can't be handed to GDCM, which ends the program when
/// the file meta information (group 0002) is cut off and asks for gigabytes when an element's length is wrong: the
/// preamble, "DICM", the explicit little-endian elements of group 0002 and its length, and the elements of the data set
/// before the pixels (PS3.10 7.1, PS3.5 7.1) must all lie within the file, and those of sequences within their
/// sequence. Where the data set holds something that the standard doesn't know it goes no further, and GDCM judges the
/// rest. Reads no pixels.
void CheckDicomHeader(const std::string& path);
/// The same of a stream that can seek; `path` names it in messages.
void CheckDicomHeader(std::istream& in, const std::string& path);

}  // namespace kerf
