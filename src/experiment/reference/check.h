// Validation of a reference's parameters, and the last step of a reference.
#pragma once

#include <atomic>
#include <vector>

#include "experiment/reference/reference.h"

namespace kerf::reference {

/// Throws Error naming the first parameter that is out of range.
void Check(const ReferenceParams& params, const std::vector<Pose>& poses);

/// Returns true if the tool is set down in tick k, which ends at the pose X[k].
bool IsSetDown(const ReferenceParams& params, std::size_t k);

/// Throws Error if `stop` is not null and `*stop` is true.
void StopIf(const std::atomic<bool>* stop);

/// Scales the removed volumes of the ticks, which were integrated from the flux, so that the last one equals the volume
/// that the bone has lost.
void SettleRemoved(ReferenceRun& run);

}  // namespace kerf::reference
