// What a reference may be asked for.
#pragma once

#include <vector>

#include "reference/reference.h"

namespace kerf::reference {

/// Throws Error naming the first figure out of range.
void Check(const ReferenceParams& params, const std::vector<Pose>& poses);

}  // namespace kerf::reference
