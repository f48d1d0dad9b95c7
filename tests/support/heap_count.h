// Counts uses of the heap through operator new and delete. Defines the program's operators: include in one file of a
// test program only.
#pragma once

#include <atomic>
#include <cstdlib>
#include <new>

namespace kerf::test {

inline std::atomic<long> heap_uses{0};

/// How often `work` took or gave back memory, in all threads.
template <typename Work>
long CountHeapUses(Work&& work) {
  const long before = heap_uses;
  work();
  return heap_uses - before;
}

inline void* CountedAllocate(std::size_t size) {
  ++heap_uses;
  void* p = std::malloc(size ? size : 1);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}
inline void CountedFree(void* p) {
  if (p != nullptr) ++heap_uses;
  std::free(p);
}
inline void* CountedAllocate(std::size_t size, std::align_val_t alignment) {
  ++heap_uses;
  const auto step = static_cast<std::size_t>(alignment);
  void* p = std::aligned_alloc(step, (size + step - 1) / step * step);
  if (p == nullptr) throw std::bad_alloc();
  return p;
}

}  // namespace kerf::test

void* operator new(std::size_t size) {
  return kerf::test::CountedAllocate(size);
}
void* operator new[](std::size_t size) {
  return kerf::test::CountedAllocate(size);
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return kerf::test::CountedAllocate(size, alignment);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return kerf::test::CountedAllocate(size, alignment);
}
void operator delete(void* p) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete[](void* p) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete(void* p, std::size_t) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete[](void* p, std::size_t) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete[](void* p, std::align_val_t) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  kerf::test::CountedFree(p);
}
void operator delete[](void* p, std::size_t, std::align_val_t) noexcept {
  kerf::test::CountedFree(p);
}
