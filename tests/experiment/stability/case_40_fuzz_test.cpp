// Hard case 40: sequences of random calls, as from any hand, device or faulty calling program.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "experiment/stability/fuzz_run.h"
#include "experiment/stability/verdict.h"

namespace kerf {
namespace {

using test::FuzzedSaw;
using test::FuzzResult;
using test::FuzzTools;

constexpr int kCalls = 1000;  // per sequence

/// Runs ticks of a saw that is coupled to a handle, in sequences of a thousand calls.
void FuzzSaw(std::uint64_t first_seed, double ticks, FuzzTools tools = FuzzTools::kDiscsAndBalls) {
  test::Verdict verdict("holds");
  FuzzedSaw::Counts sum;
  test::RunFuzz(first_seed, static_cast<long>(ticks * test::Effort()), [&](std::uint64_t seed, long& made) {
    FuzzedSaw::Counts c;
    FuzzResult result = test::FuzzCoupled(seed, kCalls, tools, c);
    made += c.ticks;
    sum.ticks += c.ticks;
    sum.touched += c.touched;
    sum.refused += c.refused;
    sum.cut += c.cut;
    sum.used_up += c.used_up;
    sum.unsolved += c.unsolved;
    sum.out_of_leaves += c.out_of_leaves;
    sum.slab += c.slab;
    return result;
  });
  const auto fraction = [&](long n) { return static_cast<double>(n) / static_cast<double>(sum.ticks); };
  verdict.AtLeast("ticks", static_cast<double>(sum.ticks), std::min(1.0, ticks * test::Effort()));
  verdict.Note("fraction with force", fraction(sum.touched));
  verdict.Note("fraction that cut", fraction(sum.cut));
  verdict.Note("fraction refused", fraction(sum.refused));
  verdict.Note("fraction with all substeps used", fraction(sum.used_up));
  verdict.Note("fraction unsolved", fraction(sum.unsolved));
  verdict.Note("fraction without spare leaves", fraction(sum.out_of_leaves));
  verdict.Note("fraction in slab mode", fraction(sum.slab));
}

TEST(HardCase40, RandomSequencesOfAHandHeldSawSatisfyEveryInvariant1) {
  FuzzSaw(1'000'000, 200'000);
}
TEST(HardCase40, RandomSequencesOfAHandHeldSawSatisfyEveryInvariant2) {
  FuzzSaw(2'000'000, 200'000);
}
TEST(HardCase40, RandomSequencesOfAHandHeldSawSatisfyEveryInvariant3) {
  FuzzSaw(3'000'000, 200'000);
}
TEST(HardCase40, RandomSequencesOfAHandHeldSawSatisfyEveryInvariant4) {
  FuzzSaw(4'000'000, 100'000);
}
TEST(HardCase40, RandomSequencesOfBursDrillsAndBladesSatisfyEveryInvariant) {
  FuzzSaw(5'000'000, 60'000, FuzzTools::kBursAndBlades);
}

using FuzzSequence = FuzzResult(std::uint64_t seed, int calls, long& ticks);

void FuzzOther(std::uint64_t first_seed, double ticks, const std::function<FuzzSequence>& run) {
  test::Verdict verdict("holds");
  long sum = 0;
  test::RunFuzz(first_seed, static_cast<long>(ticks * test::Effort()), [&](std::uint64_t seed, long& made) {
    FuzzResult result = run(seed, kCalls, made);
    sum = made;
    return result;
  });
  verdict.AtLeast("ticks", static_cast<double>(sum), std::min(1.0, ticks * test::Effort()));
}

TEST(HardCase40, RandomSequencesThroughAFaultyDeviceNeverExceedItsLimits) {
  FuzzOther(20'000'000, 100'000, test::FuzzDevice);
}

TEST(HardCase40, RandomPathsThroughBoneSatisfyEveryInvariant) {
  FuzzOther(30'000'000, 100'000, [](std::uint64_t seed, int calls, long& ticks) {
    return test::FuzzPath(seed, calls, FuzzTools::kDiscsAndBalls, ticks);
  });
}

TEST(HardCase40, RandomPathsOfBursDrillsAndBladesSatisfyEveryInvariant) {
  FuzzOther(35'000'000, 30'000, [](std::uint64_t seed, int calls, long& ticks) {
    return test::FuzzPath(seed, calls, FuzzTools::kBursAndBlades, ticks);
  });
}

TEST(HardCase40, RandomHandsOnTheThinSlabSatisfyEveryInvariant) {
  FuzzOther(40'000'000, 100'000, test::FuzzSlab);
}

}  // namespace
}  // namespace kerf
