// Tests of files that lie about their size: a process with little memory left.
#pragma once

#include <sched.h>
#include <sys/resource.h>

#include <cstdint>
#include <fstream>

namespace kerf::test {

/// From here on this process has one core: libraries that would begin a thread for each, whose stack and arena are
/// address space too, begin none. Before they are used.
inline void UseOneCore() {
  cpu_set_t cores;
  if (sched_getaffinity(0, sizeof(cores), &cores) != 0) return;
  int first = 0;
  while (first + 1 < CPU_SETSIZE && !CPU_ISSET(first, &cores)) ++first;
  CPU_ZERO(&cores);
  CPU_SET(first, &cores);
  sched_setaffinity(0, sizeof(cores), &cores);
}

/// From here on this process gets `bytes` more of address space and then std::bad_alloc. For the statement of a death
/// test: there is no way back. The address sanitizer reserves terabytes itself; under it this does nothing, and it ends
/// the program when one request is absurd.
inline void LimitMemory(std::uint64_t bytes) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  constexpr std::uint64_t kPage = 4096;
  const rlimit limit{pages * kPage + bytes, pages * kPage + bytes};
  setrlimit(RLIMIT_AS, &limit);
#else
  static_cast<void>(bytes);
#endif
}

}  // namespace kerf::test
