// Running random sequences, telling which one broke, and making it short.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "experiment/stability/fuzz.h"

namespace kerf::test {

/// The seed of KERF_FUZZ_SEED, if one is asked for: then it alone is run.
bool AskedForSeed(std::uint64_t& seed);

/// What comes of a sequence: empty when all is well.
struct FuzzResult {
  std::string wrong;
  int tick = 0;
};

/// One sequence of coupled ticks from a seed. With KERF_FUZZ_SEED set a failing one is made short and printed.
FuzzResult FuzzCoupled(std::uint64_t seed, int calls, FuzzedSaw::Counts& counts);

/// The same through HapticStep, with a device that fails and lies, or a simulated one in a hand.
FuzzResult FuzzDevice(std::uint64_t seed, int calls, long& ticks);
/// A tool that follows its path whatever stands in its way.
FuzzResult FuzzPath(std::uint64_t seed, int calls, long& ticks);
/// The thin slab.
FuzzResult FuzzSlab(std::uint64_t seed, int calls, long& ticks);

/// Runs sequences from `first_seed` on until so many ticks were made; each failure is a failure of the test, with the
/// line that repeats it. `run` gets the seed and adds to the ticks.
void RunFuzz(std::uint64_t first_seed, long ticks, const std::function<FuzzResult(std::uint64_t, long&)>& run);

}  // namespace kerf::test
