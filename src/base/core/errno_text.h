// The system's error messages.
#pragma once

#include <string>
#include <system_error>

namespace kerf {

/// Returns the system's message for an errno. Thread-safe.
inline std::string FormatErrno(int code) {
  return std::generic_category().message(code);
}

}  // namespace kerf
