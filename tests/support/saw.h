// The saw of most tests: the default disc.
#pragma once

#include "kerf/tool.h"

namespace kerf {

inline const DiscSaw kSaw;
inline const double kR = kSaw.radius_mm();

}  // namespace kerf
