// Tests that a reader of the stream receives the latest state of every leaf, and that no leaf waits forever.
#include "loop/haptics/leaf_stream.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "base/core/heap_guard.h"

namespace kerf {
namespace {

using Leaves = std::map<std::array<int, 3>, std::array<float, 512>>;

std::size_t Drain(SpscRing<LeafMessage>& ring, Leaves& leaves) {
  std::size_t n = 0;
  while (const LeafMessage* message = ring.Peek()) {
    leaves[message->index] = message->values;
    ring.Pop();
    ++n;
  }
  return n;
}

TEST(LeafStream, EndsBitIdenticalWhateverTheOrder) {
  std::mt19937 random(7);
  for (int run = 0; run < 20; ++run) {
    SpscRing<LeafMessage> ring(8);
    LeafPublisher publisher(ring, 300);
    Leaves truth;
    for (int i = 0; i < 250; ++i) {
      truth[{static_cast<int>(random() % 40) - 20, static_cast<int>(random() % 40) - 20,
             static_cast<int>(random() % 40) - 20}];
    }
    std::vector<std::array<int, 3>> names;
    for (const auto& [index, values] : truth) names.push_back(index);
    Leaves mirror = truth;
    for (int tick = 0; tick < 2000; ++tick) {
      for (int k = 0; k < 5; ++k) {
        auto& [index, values] = *truth.find(names[random() % names.size()]);
        values[random() % 512] += 1;
        ASSERT_TRUE(publisher.Mark(index, values.data()));
      }
      const HeapGuard guard;
      EXPECT_LE(publisher.Send(3), 3);
      if (tick % 5 == 0) {
        const HeapUseCounter reader_may_allocate;
        Drain(ring, mirror);
      }
    }
    while (publisher.waiting() > 0) {
      publisher.Send(3);
      Drain(ring, mirror);
    }
    Drain(ring, mirror);
    EXPECT_TRUE(mirror == truth);
  }
}

TEST(LeafStream, SendsEachWaitingLeafBeforeAnyTwice) {
  SpscRing<LeafMessage> ring(1024);
  LeafPublisher publisher(ring, 100);
  const std::array<float, 512> values{};
  // All leaves change in every tick; after 25 ticks that send 4 leaves, each leaf has been sent once.
  std::map<std::array<int, 3>, int> sent;
  for (int tick = 0; tick < 25; ++tick) {
    for (int leaf = 0; leaf < 100; ++leaf) publisher.Mark({leaf, 0, 0}, values.data());
    EXPECT_EQ(publisher.Send(4), 4);
  }
  while (const LeafMessage* message = ring.Peek()) {
    ++sent[message->index];
    ring.Pop();
  }
  EXPECT_EQ(sent.size(), 100U);
}

TEST(LeafStream, KeepsWhatTheRingHasNoRoomFor) {
  SpscRing<LeafMessage> ring(2);
  LeafPublisher publisher(ring, 10);
  std::array<float, 512> values{};
  for (int leaf = 0; leaf < 5; ++leaf) publisher.Mark({leaf, 0, 0}, values.data());
  EXPECT_EQ(publisher.Send(100), 2);
  EXPECT_EQ(publisher.Send(100), 0);
  EXPECT_EQ(publisher.waiting(), 3U);
  values[0] = 5;  // a leaf that is sent later is sent with its latest values
  Leaves got;
  EXPECT_EQ(Drain(ring, got), 2U);
  EXPECT_EQ(publisher.Send(100), 2);
  EXPECT_EQ(Drain(ring, got), 2U);
  const std::array<int, 3> third{2, 0, 0};
  EXPECT_EQ(got[third][0], 5);
}

TEST(LeafStream, ReportsAFullQueue) {
  SpscRing<LeafMessage> ring(2);
  LeafPublisher publisher(ring, 3);
  const std::array<float, 512> values{};
  for (int leaf = 0; leaf < 3; ++leaf) EXPECT_TRUE(publisher.Mark({leaf, 0, 0}, values.data()));
  EXPECT_FALSE(publisher.Mark({3, 0, 0}, values.data()));
  EXPECT_TRUE(publisher.Mark({1, 0, 0}, values.data()));  // this leaf is already waiting
  EXPECT_EQ(publisher.Send(1), 1);
  EXPECT_TRUE(publisher.Mark({3, 0, 0}, values.data()));
}

}  // namespace
}  // namespace kerf
