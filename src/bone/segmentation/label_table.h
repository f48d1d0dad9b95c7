// Names of labels in the extension of a NIfTI header.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace kerf {

/// Returns the names in the extensions of a .nii or .nii.gz file, by label: an XML table as of Caret and
/// TotalSegmentator, or JSON with names by label or labels by name. Empty if it has none that is understood.
std::map<int, std::string> ReadLabelTable(const std::string& path);

/// Returns the names in the text of one extension.
std::map<int, std::string> ParseLabelTable(std::string_view text);

}  // namespace kerf
