// Each way to request heap memory is caught inside a guard, and none outside.
#include "base/core/heap_guard.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

namespace kerf {
namespace {

class HeapGuardTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!HeapGuardIsInstalled()) GTEST_SKIP() << "the sanitizers use their own allocator";
  }
};

/// Keeps the compiler from removing an allocation whose result is not used.
void Keep(void* memory) {
  asm volatile("" : : "g"(memory) : "memory");
}

TEST_F(HeapGuardTest, CountsEveryWayToAllocateAndToFree) {
  void* old = std::malloc(64);
  struct Way {
    const char* name;
    std::function<void*()> use;
  };
  const std::vector<Way> ways = {
      {"malloc", [] { return std::malloc(100); }},
      {"calloc", [] { return std::calloc(10, 10); }},
      {"realloc", [old] { return std::realloc(old, 1000); }},
      {"aligned_alloc", [] { return std::aligned_alloc(64, 640); }},
      {"posix_memalign",
       [] {
         void* memory = nullptr;
         return posix_memalign(&memory, 64, 100) == 0 ? memory : nullptr;
       }},
      {"new", [] { return static_cast<void*>(new char); }},
      {"aligned new", [] { return ::operator new (100, std::align_val_t{64}); }},
  };
  for (const Way& way : ways) {
    const HeapUseCounter counter;
    void* got = nullptr;
    {
      const HeapGuard guard;
      got = way.use();
      Keep(got);
    }
    EXPECT_EQ(counter.count(), 1) << way.name;
    ASSERT_NE(got, nullptr) << way.name;
    {
      const HeapGuard guard;
      std::free(got);
    }
    EXPECT_EQ(counter.count(), 2) << way.name;
  }
}

TEST_F(HeapGuardTest, CountsAllocationsByContainersAndExceptions) {
  const HeapUseCounter counter;
  std::vector<int> numbers;
  {
    const HeapGuard guard;
    numbers.push_back(1);
  }
  EXPECT_EQ(counter.count(), 1);
  {
    const HeapGuard guard;
    const std::string text(100, 'x');
    Keep(const_cast<char*>(text.data()));
  }
  EXPECT_EQ(counter.count(), 3);
}

TEST_F(HeapGuardTest, AffectsOnlyItsOwnThreadAndScope) {
  const HeapUseCounter counter;
  {
    const HeapGuard guard;
    const HeapGuard inner;
  }
  Keep(std::malloc(1));  // both guards have ended
  std::atomic<bool> keep_guard{true};
  std::atomic<bool> guarded{false};
  std::thread other([&] {
    const HeapGuard guard;
    guarded = true;
    while (keep_guard) std::this_thread::yield();
  });
  while (!guarded) std::this_thread::yield();
  std::free(std::malloc(100));
  keep_guard = false;
  other.join();
  EXPECT_EQ(counter.count(), 0);
}

TEST_F(HeapGuardTest, AllowsFreeOfNullptr) {
  const HeapUseCounter counter;
  const HeapGuard guard;
  std::free(nullptr);
  EXPECT_EQ(counter.count(), 0);
}

using HeapGuardDeathTest = HeapGuardTest;

TEST_F(HeapGuardDeathTest, AbortsTheProgramWithAMessage) {
  EXPECT_DEATH(
      {
        const HeapGuard guard;
        Keep(std::malloc(100));
      },
      "kerf: heap use inside the tick: malloc");
}

}  // namespace
}  // namespace kerf
