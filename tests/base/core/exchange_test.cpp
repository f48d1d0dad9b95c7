// Values passed from one thread to another arrive complete and in order; the newest-value buffer never returns an older
// value than before. These tests also run under ThreadSanitizer.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <memory>
#include <thread>

#include "base/core/spsc_ring.h"
#include "base/core/triple_buffer.h"

namespace kerf {
namespace {

/// Large enough that a half-written record would be noticed.
struct Record {
  std::array<std::uint64_t, 64> values{};
  void Fill(std::uint64_t n) { values.fill(n); }
  bool IsWhole() const {
    for (const std::uint64_t v : values) {
      if (v != values[0]) return false;
    }
    return true;
  }
};

TEST(TripleBuffer, ReturnsOnlyTheLatestValue) {
  TripleBuffer<int> buffer(7);
  EXPECT_FALSE(buffer.Update());
  EXPECT_EQ(buffer.front(), 7);
  buffer.Publish(8);
  buffer.Publish(9);
  EXPECT_EQ(buffer.front(), 7);  // unchanged until Update()
  EXPECT_TRUE(buffer.Update());
  EXPECT_EQ(buffer.front(), 9);
  EXPECT_FALSE(buffer.Update());
  EXPECT_EQ(buffer.front(), 9);
  for (int i = 10; i < 20; ++i) {
    buffer.back() = i;
    buffer.Publish();
    EXPECT_TRUE(buffer.Update());
    EXPECT_EQ(buffer.front(), i);
  }
}

TEST(TripleBuffer, ValuesAreNeverTornOrOutOfOrder) {
  constexpr std::uint64_t kCount = 200'000;
  auto buffer = std::make_unique<TripleBuffer<Record>>();
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kCount; ++i) {
      buffer->back().Fill(i);
      buffer->Publish();
    }
    done = true;
  });
  std::uint64_t torn = 0;
  std::uint64_t backwards = 0;
  std::uint64_t last = 0;
  for (bool finished = false; !finished;) {
    finished = done;
    if (!buffer->Update()) continue;
    if (!buffer->front().IsWhole()) ++torn;
    if (buffer->front().values[0] <= last) ++backwards;
    last = buffer->front().values[0];
  }
  writer.join();
  EXPECT_EQ(torn, 0U);
  EXPECT_EQ(backwards, 0U);
  EXPECT_EQ(last, kCount);  // the last value is not lost
}

/// Returns the value taken, or -1 if the ring is empty.
int Take(SpscRing<int>& ring) {
  const int* value = ring.Peek();
  const int taken = value != nullptr ? *value : -1;
  if (value != nullptr) ring.Pop();
  return taken;
}

TEST(SpscRing, HoldsAtMostItsCapacity) {
  SpscRing<int> ring(5);
  EXPECT_EQ(ring.capacity(), 8U);
  for (int round = 0; round < 3; ++round) {  // the indices wrap around the end of the ring's memory
    EXPECT_EQ(ring.Peek(), nullptr);
    for (int i = 0; i < 8; ++i) EXPECT_TRUE(ring.TryPush(i));
    EXPECT_FALSE(ring.TryPush(8));
    EXPECT_EQ(ring.Claim(), nullptr);
    for (int i = 0; i < 5; ++i) {
      EXPECT_EQ(Take(ring), i);
    }
    for (int i = 8; i < 13; ++i) EXPECT_TRUE(ring.TryPush(i));
    EXPECT_FALSE(ring.TryPush(13));
    for (int i = 5; i < 13; ++i) {
      EXPECT_EQ(Take(ring), i);
    }
  }
}

TEST(SpscRing, LosesNothingAndKeepsTheOrder) {
  constexpr std::uint64_t kCount = 100'000;
  SpscRing<Record> ring(16);
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kCount;) {
      Record* slot = ring.Claim();
      if (slot == nullptr) {
        std::this_thread::yield();
        continue;
      }
      slot->Fill(i++);
      ring.Push();
    }
  });
  std::uint64_t wrong = 0;
  for (std::uint64_t next = 1; next <= kCount;) {
    const Record* record = ring.Peek();
    if (record == nullptr) {
      std::this_thread::yield();
      continue;
    }
    if (!record->IsWhole() || record->values[0] != next) ++wrong;
    ring.Pop();
    ++next;
  }
  writer.join();
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(ring.Peek(), nullptr);
}

}  // namespace
}  // namespace kerf
