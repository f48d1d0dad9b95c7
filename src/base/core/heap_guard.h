// Holds a stretch of code to its promise to ask for no heap memory. Costs one addition to a thread's own counter; only
// a program that is linked with the target kerf_heap_guard (the tests, and the program's debug build) looks at it.
#pragma once

#include <atomic>

namespace kerf {

namespace heap_guard {

/// How many guards the thread stands in.
constinit inline thread_local int depth = 0;
/// Whether this program was linked with what looks.
constinit inline bool installed = false;
/// True: heap use in a guard is counted; false: a line on stderr, and the program ends.
constinit inline std::atomic<bool> count_only{false};
constinit inline std::atomic<long> violations{0};

}  // namespace heap_guard

/// While one stands, malloc, free, new, delete and their kin in the same thread end the program; only free(nullptr) is
/// allowed. Guards may nest.
class HeapGuard {
 public:
  HeapGuard() noexcept { ++heap_guard::depth; }
  ~HeapGuard() { --heap_guard::depth; }
  HeapGuard(const HeapGuard&) = delete;
  HeapGuard& operator=(const HeapGuard&) = delete;
};

/// Whether anything looks: false in a release build and under the sanitizers, which have an allocator of their own.
inline bool HeapGuardIsInstalled() {
  return heap_guard::installed;
}

/// While one stands, heap use in a guard, in any thread, is counted and goes on. For tests.
class HeapUseCounter {
 public:
  HeapUseCounter() noexcept : before_(heap_guard::violations.load()) { heap_guard::count_only = true; }
  ~HeapUseCounter() { heap_guard::count_only = false; }
  HeapUseCounter(const HeapUseCounter&) = delete;
  HeapUseCounter& operator=(const HeapUseCounter&) = delete;
  long count() const { return heap_guard::violations.load() - before_; }

 private:
  long before_;
};

}  // namespace kerf
