// The elements of a DICOM file held against the bytes that are there, before GDCM is let at it.
#pragma once

#include <string>

namespace kerf {

/// Throws Error with one sentence when the DICOM file at `path` can't be handed to GDCM, which ends the program when
/// the file meta information (group 0002) is cut off and asks for gigabytes when an element's length is wrong: the
/// preamble, "DICM", the explicit little-endian elements of group 0002 and its length, and the elements of the data set
/// before the pixels (PS3.10 7.1, PS3.5 7.1) must all lie within the file. Follows sequences; where the data set holds
/// something that the standard doesn't know it goes no further, and GDCM judges the rest. Reads no pixels.
void CheckDicomHeader(const std::string& path);

}  // namespace kerf
