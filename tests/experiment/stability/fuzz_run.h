// Runs random sequences; reports and shortens the one that fails.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "experiment/stability/fuzz.h"

namespace kerf::test {

/// Returns true if KERF_FUZZ_SEED is set, and stores its value in `seed`. In that case only that sequence runs.
bool AskedForSeed(std::uint64_t& seed);

/// Result of a sequence: `wrong` is empty if all invariants hold.
struct FuzzResult {
  std::string wrong;
  int tick = 0;
};

/// Runs a sequence of coupled ticks from a seed. If KERF_FUZZ_SEED is set, shortens and prints a failing sequence.
FuzzResult FuzzCoupled(std::uint64_t seed, int calls, FuzzTools tools, FuzzedSaw::Counts& counts);

/// Runs a sequence through HapticStep, with a device that fails and delivers bad samples, or with a simulated device
/// and hand.
FuzzResult FuzzDevice(std::uint64_t seed, int calls, long& ticks);
/// Runs a sequence for a tool that follows its path through any obstacle.
FuzzResult FuzzPath(std::uint64_t seed, int calls, FuzzTools tools, long& ticks);
/// Runs a sequence for the thin slab.
FuzzResult FuzzSlab(std::uint64_t seed, int calls, long& ticks);

/// Runs sequences from `first_seed` on until the number of ticks reaches `ticks`. Each failed sequence fails the test,
/// with the command that repeats it. `run` receives the seed and adds to the tick count.
void RunFuzz(std::uint64_t first_seed, long ticks, const std::function<FuzzResult(std::uint64_t, long&)>& run);

}  // namespace kerf::test
