// Check of a DICOM file's elements against its actual bytes, before GDCM reads it.
#pragma once

#include <istream>
#include <string>

namespace kerf {

/// Throws kerf::Error with one sentence if the DICOM file at `path` cannot safely be passed to GDCM. GDCM ends the
/// program if the file meta information (group 0002) is truncated, and allocates gigabytes if an element's length is
/// wrong. Therefore the preamble, "DICM", the explicit little-endian elements of group 0002 and its length, and the
/// elements of the data set before the pixels (PS3.10 7.1, PS3.5 7.1) must all lie within the file, and the elements of
/// a sequence within that sequence. The check ends where the data set contains something not in the standard; the rest
/// is left to GDCM. Reads no pixels.
void CheckDicomHeader(const std::string& path);
/// Overload for a seekable stream; `path` names it in messages.
void CheckDicomHeader(std::istream& in, const std::string& path);

}  // namespace kerf
