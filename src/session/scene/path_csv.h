// The path of a tool as CSV: time, position, quaternion.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

/// Rows of text under the header `time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz`: pose X_WT of the tool in the world. Blank lines
/// and lines that start with '#' are skipped. Needs at least 2 rows and at most kMaxPathRows, time increasing by at
/// least 1e-6 s a row and over at most kMaxDuration_s, coordinates in kCoordinateRange_mm, quaternions of length 1 to
/// 1e-3 (they are made exactly unit). `file` names the text in messages. Throws Error with a line `file:line:column:
/// ...` for each fault.
std::vector<TimedPose> ParsePathCsv(const std::string& text, const std::string& file);

/// The same as text, that reads back: quaternions to their last bits, the rest exactly.
std::string FormatPathCsv(const std::vector<TimedPose>& poses);

}  // namespace kerf
