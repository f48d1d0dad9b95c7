// Lower bounds on the files that a run or a loop will write, computed before it starts.
#pragma once

#include <string>
#include <vector>

#include "base/files/disk_space.h"
#include "session/scene/scene.h"

namespace kerf {

/// Returns lower bounds that are computed from the sizes of rows and recorded ticks in which nothing happens. `ticks`:
/// number of ticks of the path, or requested for the loop. `folder`, `record`: empty if there is none.
std::vector<ExpectedFile> ListExpectedFiles(const Scene& scene, double ticks, const std::string& folder,
                                            const std::string& record);

/// Returns a sentence if the minimum that a loop writes does not fit on the disk: either the recording alone, or
/// forces.csv in addition to the space reserved for the recording. Returns "" if they fit.
std::string DescribeLackForLoop(const Scene& scene, double ticks, const std::string& folder, const std::string& record);

/// Returns the disk space that a loop's log leaves free for its recording, bytes: twice the typical size of the
/// recorded ticks.
double CalcRoomForRecording(double ticks);

}  // namespace kerf
