// Measurements of the tick other than cutting.
#pragma once

#include "experiment/bench/cut_case.h"

namespace kerf {

/// Times ticks in which the saw hovers 5 mm above a block at the speed of a hand: flat, on edge and in between.
BenchResult RunIdle(const BenchOptions& options);

/// Measures the memory of a whole mandible with 0.1 mm voxels and of a block of 256^3 voxels, each with a simulation
/// that is ready to run ticks.
BenchResult RunMemory(const BenchOptions& options);

}  // namespace kerf
