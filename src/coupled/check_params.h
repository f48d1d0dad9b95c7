// The ranges of CoupledParams.
#pragma once

#include "kerf/coupled.h"

namespace kerf {

/// Throws Error naming the first value out of range.
void CheckParams(const CoupledParams& params);

}  // namespace kerf
