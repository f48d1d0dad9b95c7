// The sense in which a tool turns.
#pragma once

#include "kerf/tool.h"

namespace kerf {

/// Returns the sense in which this kind of tool turns to cut, about z of T: 1 or, clockwise as seen from +z, -1. The
/// handpiece of a tool that turns is on the side of +z. 1 for a stroke, which has no sense.
int GetSense(const Tool& tool);

}  // namespace kerf
