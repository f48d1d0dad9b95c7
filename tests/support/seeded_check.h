// RapidCheck with the same cases in every run.
#pragma once

#include <rapidcheck.h>

#include <iostream>
#include <utility>

namespace kerf::test {

/// True when the property holds in `runs` cases drawn from `seed`; says on stderr what was found.
template <typename Property>
bool CheckSeeded(std::uint64_t seed, int runs, Property&& property) {
  rc::detail::TestParams params;
  params.seed = seed;
  params.maxSuccess = runs;
  params.disableShrinking = true;  // of what is drawn from a random number, none is simpler than another
  const auto result = rc::detail::checkTestable(std::forward<Property>(property), rc::detail::TestMetadata{}, params);
  rc::detail::printResultMessage(result, std::cerr);
  std::cerr << std::endl;
  return result.template is<rc::detail::SuccessResult>();
}

}  // namespace kerf::test
