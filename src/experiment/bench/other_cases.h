// Measurements of the tick other than cutting.
#pragma once

#include "experiment/bench/cut_case.h"

namespace kerf {

/// The saw hovers 5 mm above a block: flat, on edge and in between, at the speed of a hand.
BenchResult RunIdle(const BenchOptions& options);

/// Memory of a whole mandible with 0.1 mm voxels and of a block of 256^3, ready for the tick.
BenchResult RunMemory(const BenchOptions& options);

}  // namespace kerf
