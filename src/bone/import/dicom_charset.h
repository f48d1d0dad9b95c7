// Character sets of the texts in a DICOM file.
#pragma once

#include <string>
#include <string_view>

namespace kerf {

/// Returns a text of a DICOM file as UTF-8, in which '?' stands for each character that is not printable
/// (core/printable.h) or not in its character set; at most 1000 characters. `character_sets`: the value of
/// SpecificCharacterSet (0008,0005) with its backslashes, such as "ISO_IR 100" or "\\ISO 2022 IR 87"; empty: ASCII.
/// Bytes above 127 that no character set explains are read as UTF-8 if they are valid UTF-8, otherwise as ISO 8859-1.
std::string DecodeDicomText(std::string_view text, std::string_view character_sets);

}  // namespace kerf
