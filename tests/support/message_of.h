// The message of an error that a call throws.
#pragma once

#include <functional>
#include <string>

#include "kerf/error.h"

namespace kerf::test {

/// Returns the message of the Error that `f` throws, or `otherwise` if it throws none.
inline std::string MessageOf(const std::function<void()>& f, const std::string& otherwise = "") {
  try {
    f();
  } catch (const Error& e) {
    return e.what();
  }
  return otherwise;
}

}  // namespace kerf::test
