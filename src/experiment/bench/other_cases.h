// What is measured of the tick beside cutting.
#pragma once

#include "experiment/bench/cut_case.h"

namespace kerf {

/// The saw hovers 5 mm over a block: flat, on edge and in between, at a hand's pace.
BenchResult RunIdle(const BenchOptions& options);

/// What a whole mandible of 0.1 mm voxels and a block of 256^3 take, ready for the tick.
BenchResult RunMemory(const BenchOptions& options);

}  // namespace kerf
