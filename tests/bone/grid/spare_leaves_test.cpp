#include "bone/grid/spare_leaves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>
#include <vector>

#include "base/core/heap_guard.h"

namespace kerf {
namespace {

bool IsFilled(const SpareLeaves::Leaf& leaf, float value) {
  const float* const values = leaf.buffer().data();
  return leaf.isInactive() &&
         std::all_of(values, values + SpareLeaves::Leaf::SIZE, [=](float v) { return v == value; });
}

TEST(SpareLeaves, CountsTheLeavesThatAreLeft) {
  SpareLeaves spare(-0.3f);
  EXPECT_EQ(spare.count(), 0);
  spare.Refill(3);
  spare.Refill(2);  // there are more
  EXPECT_EQ(spare.count(), 3);
  spare.Supply(5);
  spare.Supply(4);
  EXPECT_EQ(spare.count(), 5);
  std::vector<std::unique_ptr<SpareLeaves::Leaf>> taken;
  const HeapUseCounter heap_uses;
  {
    taken.reserve(5);
    const HeapGuard guard;
    while (spare.count() > 0) taken.push_back(spare.Take({8, 16, -24}));
  }
  EXPECT_EQ(heap_uses.count(), 0);
  ASSERT_EQ(taken.size(), 5u);
  for (const auto& leaf : taken) {
    EXPECT_TRUE(IsFilled(*leaf, -0.3f));
    EXPECT_EQ(leaf->origin(), openvdb::Coord(8, 16, -24));
  }
  taken[0]->buffer().fill(7);
  spare.Return(std::move(taken[0]));
  EXPECT_EQ(spare.count(), 1);
  EXPECT_TRUE(IsFilled(*spare.Take({0, 0, 0}), -0.3f));
}

TEST(SpareLeaves, SupplyIsBounded) {
  SpareLeaves spare(1);
  spare.Supply(1 << 20);
  EXPECT_EQ(spare.count(), 65536);
  for (int i = 0; i < 10; ++i) spare.Take({0, 0, 0});
  spare.Supply(1 << 20);
  EXPECT_EQ(spare.count(), 65536);
}

TEST(SpareLeaves, OneThreadTakesWhileAnotherSupplies) {
  constexpr int kTaken = 100'000;
  SpareLeaves spare(-1);
  spare.Refill(100);
  const std::jthread supplier([&](const std::stop_token& stop) {
    while (!stop.stop_requested()) spare.Supply(200);
  });
  // A leaf that was taken twice would be taken while it is still held.
  std::vector<std::unique_ptr<SpareLeaves::Leaf>> held(64);
  std::set<const SpareLeaves::Leaf*> all_held;
  bool right = true;
  for (int taken = 0; taken < kTaken;) {
    if (spare.count() == 0) {
      std::this_thread::yield();
      continue;
    }
    std::unique_ptr<SpareLeaves::Leaf>& place = held[static_cast<std::size_t>(taken) % held.size()];
    if (place) all_held.erase(place.get());
    if (place && taken % 3 == 0) spare.Return(std::move(place));
    place = spare.Take({taken, 0, 0});
    right = right && all_held.insert(place.get()).second && IsFilled(*place, -1);
    place->buffer().fill(static_cast<float>(taken));
    ++taken;
  }
  EXPECT_TRUE(right);
}

}  // namespace
}  // namespace kerf
