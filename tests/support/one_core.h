// Tests that must come out the same on a machine of many cores.
#pragma once

#include <sched.h>

#include <stdexcept>

namespace kerf::test {

/// The first core that this process may use.
inline int FindFirstCore() {
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) throw std::runtime_error("no cores are told");
  int first = 0;
  while (first + 1 < CPU_SETSIZE && !CPU_ISSET(first, &cores)) ++first;
  return first;
}

/// From here on this process has one core: libraries that would begin a thread for each, whose stack and arena are
/// address space too, begin none. Before they are used.
inline void UseOneCore() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(FindFirstCore(), &cores);
  sched_setaffinity(0, sizeof(cores), &cores);
}

}  // namespace kerf::test
