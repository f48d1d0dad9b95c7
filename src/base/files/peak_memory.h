// Peak memory of this program.
#pragma once

#include <sys/resource.h>

namespace kerf {

/// Returns the largest amount of memory that this program has used, MB (10^6 bytes).
inline double ReadPeakMemory_MB() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1.024e-3 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace kerf
