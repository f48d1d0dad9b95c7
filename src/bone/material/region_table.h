// Limits and ids of the region table (kerf/material.h).
#pragma once

#include "kerf/material.h"

namespace kerf {

/// Largest E of a table, MPa: ten times that of diamond; a larger value means a wrong unit.
inline constexpr double kMaxTableE_MPa = 1e7;
inline constexpr int kCancellousRegion = 32;
inline constexpr int kToothRegion = 33;
inline constexpr int kCanalRegion = 34;

}  // namespace kerf
