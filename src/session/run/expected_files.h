// What a run or a loop is going to write at least, before it is begun.
#pragma once

#include <string>
#include <vector>

#include "base/files/disk_space.h"
#include "session/scene/scene.h"

namespace kerf {

/// Lower bounds from how long the rows and the ticks' blocks are where nothing happens. `ticks`: of the path, or asked
/// for. `folder`, `record`: empty when there is none.
std::vector<ExpectedFile> ListExpectedFiles(const Scene& scene, double ticks, const std::string& folder,
                                            const std::string& record);

/// A sentence when what a loop surely writes does not fit: the recording, or else forces.csv beside the room that it
/// leaves to the recording; empty when they fit.
std::string DescribeLackForLoop(const Scene& scene, double ticks, const std::string& folder, const std::string& record);

/// What a loop's log leaves free for its recording, bytes: twice what the ticks take as a rule.
double CalcRoomForRecording(double ticks);

}  // namespace kerf
