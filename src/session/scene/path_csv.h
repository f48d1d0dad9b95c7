// Path of a tool as CSV: time, position, quaternion.
#pragma once

#include <string>
#include <vector>

#include "session/scene/scene.h"

namespace kerf {

/// Parses rows with the header `time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz`: pose X_WT of the tool in the world. Blank lines and
/// lines that start with '#' are skipped. Requires at least 2 rows and at most kMaxPathRows, time increasing by at
/// least 1e-6 s per row and spanning at most kMaxDuration_s, coordinates in kCoordinateRange_mm, quaternions of length
/// 1 to within 1e-3 (they are normalised). `file` names the text in messages. Throws kerf::Error with a line
/// `file:line:column: ...` for each fault.
std::vector<TimedPose> ParsePathCsv(const std::string& text, const std::string& file);

/// Formats poses as text that can be parsed again: quaternions to within their last bits, everything else exactly.
std::string FormatPathCsv(const std::vector<TimedPose>& poses);

}  // namespace kerf
