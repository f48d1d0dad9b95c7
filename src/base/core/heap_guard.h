// Checks that a section of code uses no heap memory. A guard costs one addition to a thread-local counter. Only
// programs linked with the target kerf_heap_guard (the tests and the debug build) check the counter.
#pragma once

#include <atomic>

namespace kerf {

namespace heap_guard {

/// Number of guards that are active in this thread.
constinit inline thread_local int depth = 0;
/// True if this program was linked with the checks.
constinit inline bool installed = false;
/// True: heap use under a guard is only counted. False: it prints a line on stderr and aborts the program.
constinit inline std::atomic<bool> count_only{false};
constinit inline std::atomic<long> violations{0};

}  // namespace heap_guard

/// While a guard exists, malloc, free, new, delete and related calls in the same thread abort the program; only
/// free(nullptr) is allowed. Guards may be nested.
class HeapGuard {
 public:
  HeapGuard() noexcept { ++heap_guard::depth; }
  ~HeapGuard() { --heap_guard::depth; }
  HeapGuard(const HeapGuard&) = delete;
  HeapGuard& operator=(const HeapGuard&) = delete;
};

/// While it exists, the guards of this thread have no effect: for a fault that ends the tick.
class HeapGuardPause {
 public:
  HeapGuardPause() noexcept : depth_(heap_guard::depth) { heap_guard::depth = 0; }
  ~HeapGuardPause() { heap_guard::depth = depth_; }
  HeapGuardPause(const HeapGuardPause&) = delete;
  HeapGuardPause& operator=(const HeapGuardPause&) = delete;

 private:
  int depth_;
};

/// Returns true if heap use is checked: false in a release build and under the sanitizers, which replace the allocator.
inline bool HeapGuardIsInstalled() {
  return heap_guard::installed;
}

/// While a counter exists, heap use under a guard is counted and allowed, in any thread. For tests.
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
