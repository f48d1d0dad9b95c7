// Runs RapidCheck with the same cases in every run.
#pragma once

#include <rapidcheck.h>

#include <iostream>
#include <utility>

namespace kerf::test {

/// Returns true if the property holds in `runs` cases drawn from `seed`. Prints the result on stderr.
template <typename Property>
bool CheckSeeded(std::uint64_t seed, int runs, Property&& property) {
  rc::detail::TestParams params;
  params.seed = seed;
  params.maxSuccess = runs;
  params.disableShrinking = true;  // cases drawn from a random number have no simpler form
  const auto result = rc::detail::checkTestable(std::forward<Property>(property), rc::detail::TestMetadata{}, params);
  rc::detail::printResultMessage(result, std::cerr);
  std::cerr << std::endl;
  return result.template is<rc::detail::SuccessResult>();
}

}  // namespace kerf::test
