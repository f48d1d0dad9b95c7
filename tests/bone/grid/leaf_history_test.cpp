// Earlier states of leaves, passed from the writer's side to the reader's.
#include "bone/grid/leaf_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "base/core/heap_guard.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// A box with leaves of pure bone and leaves at the surface.
struct Kept {
  explicit Kept(std::size_t ring_leaves = 256)
      : bone(test::MakeBox({}, {12, 12, 12}, 0.25)), field(bone, 200), history(field, ring_leaves) {
    field.set_history(&history);
    const LeafIndex low = field.lowest(), high = field.highest();
    for (int x = low.x; x <= high.x; ++x) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int z = low.z; z <= high.z; ++z) {
          const BoneField::LeafKind kind = field.kind({x, y, z});
          if (kind == BoneField::LeafKind::kOwn) own.push_back({x, y, z});
          if (kind == BoneField::LeafKind::kInside) inside.push_back({x, y, z});
        }
      }
    }
  }
  void Cut(const LeafIndex& leaf, float value) {
    const HeapGuard guard;
    const BoneField::CutValues values = field.Write(leaf);
    ASSERT_NE(values.cut, nullptr);
    std::fill_n(values.cut, 512, value);
    BoneField::SetPhi(values);
  }
  Bone bone;
  BoneField field;
  LeafHistory history;
  std::vector<LeafIndex> own, inside;
};

TEST(LeafHistory, StoresOldValuesOfEachLeafOncePerEpoch) {
  Kept k;
  EXPECT_TRUE(k.field.NeedsOldValues(k.own[0]));
  k.Cut(k.own[0], 0.1F);
  k.Cut(k.own[0], 0.2F);
  k.Cut(k.inside[0], 0.3F);
  EXPECT_FALSE(k.field.NeedsOldValues(k.own[0]));
  std::array<double, 256> figures{};
  figures[7] = 0.1;
  EXPECT_TRUE(k.history.Checkpoint(5, figures));
  EXPECT_TRUE(k.field.NeedsOldValues(k.own[0]));
  k.Cut(k.own[0], 0.4F);
  k.Cut(k.inside[0], 0.5F);
  EXPECT_EQ(k.history.pushed(), 5u);
  std::vector<LeafBefore> reported;
  while (const LeafBefore* before = k.history.ring().Peek()) {
    reported.push_back(*before);
    k.history.ring().Pop();
  }
  ASSERT_EQ(reported.size(), 5u);
  EXPECT_EQ(reported[0].kind, LeafBefore::Kind::kInside);  // nothing was cut at the surface either
  EXPECT_EQ(k.field.FromWorld(reported[0].index), k.own[0]);
  EXPECT_EQ(reported[1].kind, LeafBefore::Kind::kInside);
  EXPECT_EQ(reported[2].kind, LeafBefore::Kind::kCheckpoint);
  EXPECT_EQ(reported[2].number, 5u);
  EXPECT_EQ(reported[2].figures(), figures);
  EXPECT_EQ(reported[3].values[511], 0.2F);
  EXPECT_EQ(reported[4].kind, LeafBefore::Kind::kValues);  // kValues, because this leaf has been cut before
  EXPECT_EQ(reported[4].values[0], 0.3F);
  EXPECT_EQ(reported[4].epoch, reported[1].epoch + 1);
  // Entries remain accessible after they have been read.
  EXPECT_EQ(k.history.At(3)->values[511], 0.2F);
  EXPECT_EQ(k.history.At(5), nullptr);
}

TEST(LeafHistory, ReportsLostValuesWhenTheRingIsFull) {
  Kept k(4);
  for (std::size_t i = 0; i < 4; ++i) k.Cut(k.own[i], 0);
  EXPECT_EQ(k.history.last_lost(), 0u);
  EXPECT_FALSE(k.history.Checkpoint(1, {}));
  k.Cut(k.own[4], 0);
  const std::uint32_t lost = k.history.last_lost();
  EXPECT_EQ(lost, k.history.ring().Peek()->epoch);
  k.history.ring().Pop();
  EXPECT_TRUE(k.history.Checkpoint(1, {}));
  EXPECT_EQ(k.history.At(0), nullptr);  // its slot in the ring has been reused
  for (int i = 0; i < 4; ++i) k.history.ring().Pop();
  k.Cut(k.own[4], 1);
  EXPECT_EQ(k.history.last_lost(), lost);
  EXPECT_EQ(k.history.ring().Peek()->epoch, lost + 1);
}

TEST(LeafHistory, SwapIsNotRecorded) {
  Kept k;
  std::vector<float> values(512, 0.5F);
  const float was = k.field.Read(k.inside[3])[0];
  {
    const HeapGuard guard;
    EXPECT_TRUE(k.field.Swap(k.inside[3], values.data()));
  }
  EXPECT_EQ(k.history.pushed(), 0u);
  EXPECT_EQ(values[17], was);
  EXPECT_EQ(k.field.Read(k.inside[3])[17], 0.5F);
  EXPECT_TRUE(k.field.NeedsOldValues(k.inside[3]));
  EXPECT_EQ(k.field.changed().size(), 1u);
}

}  // namespace
}  // namespace kerf
