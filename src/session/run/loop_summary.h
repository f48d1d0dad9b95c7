// Summary of a coupled session.
#pragma once

#include "loop/haptics/haptic_loop.h"
#include "session/run/run_loop.h"

namespace kerf {

/// Collects times and counts of a loop that has ended.
void SummarizeLoop(const HapticLoop& loop, LoopSummary& s);
/// Summarises the bone and its pieces after the run. `keep`: keeps them in the summary.
void SummarizeBone(Bone bone, const Scene& scene, bool keep, LoopSummary& s);

}  // namespace kerf
