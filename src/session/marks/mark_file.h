// Marks as curves of 3D Slicer (.mrk.json).
#pragma once

#include <string>
#include <vector>

#include "session/marks/mark.h"

namespace kerf {

/// Reads each curve of a .mrk.json file as a mark. The keys `radius` (mm) and `kind` (a word of kMarkKindWords) are
/// kerf's; 3D Slicer ignores them and does not keep them. Without them, the radius is 1 mm, and the kind is the word
/// with which the name begins, otherwise "other". Throws kerf::Error with one sentence if the file is not valid or
/// CheckMarks() refuses its content.
std::vector<Mark> ReadMarks(const std::string& path);
std::vector<Mark> ParseMarks(const std::string& text, const std::string& path);

/// Writes through a temporary file. Reading gives equal marks; marks without points are left out. Throws kerf::Error.
void WriteMarks(const std::string& path, const std::vector<Mark>& marks);
std::string FormatMarks(const std::vector<Mark>& marks);

}  // namespace kerf
