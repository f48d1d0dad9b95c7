// What a reference may be asked for, and what is done at its end.
#pragma once

#include <atomic>
#include <vector>

#include "experiment/reference/reference.h"

namespace kerf::reference {

/// Throws Error naming the first figure out of range.
void Check(const ReferenceParams& params, const std::vector<Pose>& poses);

/// Tick k, which ends at the pose X[k], is one in which the tool is set down.
bool IsSetDown(const ReferenceParams& params, std::size_t k);

/// Throws Error once it is true; null: never.
void StopIf(const std::atomic<bool>* stop);

/// Stretches what the ticks say was removed, which flux has gathered, so that the last says what the bone has lost.
void SettleRemoved(ReferenceRun& run);

}  // namespace kerf::reference
