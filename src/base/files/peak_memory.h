// Peak memory of this program.
#pragma once

#include <sys/resource.h>

namespace kerf {

/// Returns the largest amount of memory that this program has used, in units of 1024 * 1024 bytes.
inline double ReadPeakMemory_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace kerf
