// How many cases the tests of random input draw.
#pragma once

#include <cstdlib>

namespace kerf::test {

/// Returns the number of cases of a test that draws a million of them in .ci/nightly: the fraction of a million in the
/// environment variable KERF_TEST_SCALE, 1/20 by default.
inline int CountRandomCases() {
  const char* scale = std::getenv("KERF_TEST_SCALE");
  return static_cast<int>(1e6 * (scale != nullptr ? std::atof(scale) : 0.05));
}

}  // namespace kerf::test
