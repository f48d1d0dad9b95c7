// Tests of files that lie about their size: a process with little memory left.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <fstream>

namespace kerf::test {

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
