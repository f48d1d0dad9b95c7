// Limits the memory of a process, for tests of files with wrong size fields.
#pragma once

#include <sys/resource.h>

#include <cstdint>
#include <fstream>

namespace kerf::test {

/// Limits the address space of this process to `bytes` more than now; beyond that, std::bad_alloc is thrown. This
/// cannot be undone, so call it in the statement of a death test. It has no effect with the address sanitizer or the
/// thread sanitizer: the address sanitizer itself reserves terabytes, and ends the program at an absurdly large
/// request.
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
