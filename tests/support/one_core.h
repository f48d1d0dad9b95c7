// Restricts a test to one core, for equal results on any machine.
#pragma once

#include <sched.h>

#include <stdexcept>

namespace kerf::test {

/// Returns the first core that this process may use.
inline int FindFirstCore() {
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) throw std::runtime_error("the allowed cores are unknown");
  int first = 0;
  while (first + 1 < CPU_SETSIZE && !CPU_ISSET(first, &cores)) ++first;
  return first;
}

/// Restricts this process to one core. Libraries then start no thread per core, whose stacks and arenas would take
/// address space. Must be called before they are used.
inline void UseOneCore() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(FindFirstCore(), &cores);
  sched_setaffinity(0, sizeof(cores), &cores);
}

}  // namespace kerf::test
