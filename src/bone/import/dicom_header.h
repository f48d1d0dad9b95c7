// Check of a DICOM file's elements against its actual bytes, before GDCM reads it.
#pragma once

#include <cstdint>
#include <istream>
#include <string>
#include <string_view>

namespace kerf {

/// What the elements before the pixels state, as far as they can be read.
struct DicomOutline {
  std::string class_uid;        // of the object; empty: not stated
  std::string series_uid;       // empty: not stated
  std::uint64_t pixels_at = 0;  // offset of the element of the pixels, unless the data set is deflated; 0: not found
  bool ends_early = false;      // the file ends before the pixels do, as far as it states their length
};

/// Returns whether a file that begins with `head`, its first 132 bytes, is a DICOM file: "DICM" after a preamble of 128
/// bytes or, as old scanners write, an element of group 0002 or 0008 at byte 0.
bool BeginsLikeDicom(std::string_view head);

/// Throws kerf::Error with one sentence if the DICOM file at `path` cannot safely be passed to GDCM. GDCM ends the
/// program if the file meta information (group 0002) is truncated, and allocates gigabytes if an element's length is
/// wrong. Therefore the elements of group 0002, if there are any, and its length, and the elements of the data set
/// before the pixels (PS3.10 7.1, PS3.5 7.1) must all lie within the file, and the elements of a sequence within that
/// sequence. The preamble may be missing; without a transfer syntax, the data set is little-endian and has explicit
/// types if its first element has one. The check ends where the data set contains something not in the standard; the
/// rest is left to GDCM. A deflated data set is unpacked, up to kMaxSliceBytes. Reads no pixels otherwise. `outline`,
/// which may be null, is set also if the check fails.
void CheckDicomHeader(const std::string& path, DicomOutline* outline = nullptr);
/// Overload for a seekable stream; `path` names it in messages.
void CheckDicomHeader(std::istream& in, const std::string& path, DicomOutline* outline = nullptr);

}  // namespace kerf
