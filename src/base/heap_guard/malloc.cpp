// Heap functions of the C library with the checks of core/heap_guard.h. They replace the C library's own in every
// program that links this file. The operators new and delete also call them.
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>

#include "base/core/heap_guard.h"

// glibc's implementations, under the names that it reserves for replacements of malloc.
extern "C" {
void* __libc_malloc(std::size_t size);                           // NOLINT(bugprone-reserved-identifier)
void* __libc_calloc(std::size_t count, std::size_t size);        // NOLINT(bugprone-reserved-identifier)
void* __libc_realloc(void* memory, std::size_t size);            // NOLINT(bugprone-reserved-identifier)
void* __libc_memalign(std::size_t alignment, std::size_t size);  // NOLINT(bugprone-reserved-identifier)
void __libc_free(void* memory);                                  // NOLINT(bugprone-reserved-identifier)
}

namespace {

[[maybe_unused]] const bool installed = [] { return kerf::heap_guard::installed = true; }();

/// Reports a violation. Must not use the heap itself.
[[gnu::noinline, gnu::cold]] void Report(const char* call) {
  kerf::heap_guard::violations.fetch_add(1);
  if (kerf::heap_guard::count_only.load()) return;
  // One write() call, so that lines of several threads do not mix.
  char line[96];
  std::size_t length = 0;
  for (const char* part : {"kerf: heap use inside the tick: ", call, "\n"}) {
    for (; *part != '\0' && length < sizeof(line); ++part) line[length++] = *part;
  }
  [[maybe_unused]] const auto written = write(STDERR_FILENO, line, length);
  kerf::heap_guard::depth = 0;  // abort() may use the heap
  std::abort();
}

inline void Check(const char* call) {
  if (kerf::heap_guard::depth > 0) [[unlikely]]
    Report(call);
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) {
  Check("malloc");
  return __libc_malloc(size);
}

void* calloc(std::size_t count, std::size_t size) {
  Check("calloc");
  return __libc_calloc(count, size);
}

void* realloc(void* memory, std::size_t size) {
  Check("realloc");
  return __libc_realloc(memory, size);
}

void* reallocarray(void* memory, std::size_t count, std::size_t size) {
  Check("reallocarray");
  std::size_t bytes = 0;
  if (__builtin_mul_overflow(count, size, &bytes)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_realloc(memory, bytes);
}

void* memalign(std::size_t alignment, std::size_t size) {
  Check("memalign");
  return __libc_memalign(alignment, size);
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  Check("aligned_alloc");
  return __libc_memalign(alignment, size);
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  Check("posix_memalign");
  if (alignment % sizeof(void*) != 0 || alignment == 0 || (alignment & (alignment - 1)) != 0) return EINVAL;
  void* got = __libc_memalign(alignment, size);
  if (got == nullptr) return ENOMEM;
  *memory = got;
  return 0;
}

void free(void* memory) {
  if (memory == nullptr) return;
  Check("free");
  __libc_free(memory);
}

}  // extern "C"
