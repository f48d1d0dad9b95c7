// Copies of a bone that share leaves: independent of each other, and no larger than what was changed in them.
#include "bone/grid/shared_leaves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <vector>

#include "base/core/heap_guard.h"
#include "bone/grid/field.h"
#include "bone/grid/grids.h"
#include "bone/grid/set_leaf.h"
#include "support/solids.h"

namespace kerf {
namespace {

constexpr std::array<int, 3> kSurfaceLeaf{3, 0, 0};  // contains the surface of the sphere of 25 voxels

Bone MakeSharedSphere() {
  Bone bone = test::MakeSphere({0, 0, 0}, 5, 0.2);
  ShareLeaves(bone);
  return bone;
}

/// Returns the number of leaves of `a` that `b` has too, as the same memory.
int CountShared(const Bone& a, const Bone& b) {
  std::set<const float*> of_a;
  for (auto leaf = GridsOf(a).phi->constTree().cbeginLeaf(); leaf; ++leaf) of_a.insert(leaf->buffer().data());
  int shared = 0;
  for (auto leaf = GridsOf(b).phi->constTree().cbeginLeaf(); leaf; ++leaf) {
    shared += static_cast<int>(of_a.count(leaf->buffer().data()));
  }
  return shared;
}

int CountLeaves(const Bone& bone) {
  return static_cast<int>(GridsOf(bone).phi->constTree().leafCount());
}

/// Cuts all voxels with x > 0 out of a bone, without allocation once the field exists.
void CutHalf(Bone& bone) {
  BoneField field(bone, 2000);
  const LeafIndex low = field.lowest(), high = field.highest();
  {
    const HeapGuard guard;
    for (int x = 0; x <= high.x; ++x) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int z = low.z; z <= high.z; ++z) {
          const BoneField::CutValues values = field.Write({x, y, z});
          if (values.cut == nullptr) continue;
          for (int i = 0; i < BoneField::kLeafVoxels; ++i) {
            values.cut[i] = static_cast<float>(std::clamp(0.2 * (8 * x + i / 64), -field.band_mm(), field.band_mm()));
          }
          BoneField::SetPhi(values);
        }
      }
    }
  }
  field.Settle();
}

TEST(SharedLeaves, CopiesShareAllLeavesAndHaveTheSameValues) {
  const Bone plain = test::MakeSphere({0, 0, 0}, 5, 0.2);
  const Bone bone = MakeSharedSphere();
  const Bone copy = CopySharing(bone);
  for (const Bone* of : {&bone, &copy}) {
    EXPECT_EQ(of->CalcHash(), plain.CalcHash());
    EXPECT_EQ(of->CountActiveVoxels(), plain.CountActiveVoxels());
    EXPECT_EQ(of->CalcVolume(), plain.CalcVolume());
    EXPECT_TRUE(GridsOf(*of).phi->constTree().hasSameTopology(GridsOf(plain).phi->constTree()));
  }
  EXPECT_EQ(CountShared(bone, copy), CountLeaves(plain));
  EXPECT_EQ(CountShared(bone, Bone(bone)), 0);  // of a plain copy
  EXPECT_EQ(CountShared(plain, CopySharing(plain)), 0);
}

TEST(SharedLeaves, AChangedLeafIsTheBonesOwn) {
  const Bone bone = MakeSharedSphere();
  const std::uint64_t hash = bone.CalcHash();
  Bone copy = CopySharing(bone);
  std::array<float, 512> cut;
  cut.fill(0.1F);
  SetCut(copy, kSurfaceLeaf, cut);
  EXPECT_EQ(bone.CalcHash(), hash);
  EXPECT_EQ(CountShared(bone, copy), CountLeaves(bone) - 1);
  Bone plain = test::MakeSphere({0, 0, 0}, 5, 0.2);
  SetCut(plain, kSurfaceLeaf, cut);
  EXPECT_EQ(copy.CalcHash(), plain.CalcHash());
  EXPECT_EQ(copy.CalcVolume(), plain.CalcVolume());
  // A copy of the copy has a leaf of its own too, and shares the others.
  const Bone again = CopySharing(copy);
  EXPECT_EQ(again.CalcHash(), copy.CalcHash());
  EXPECT_EQ(CountShared(copy, again), CountLeaves(bone) - 1);
}

TEST(SharedLeaves, ACutIsTheSameAsInABoneThatSharesNothing) {
  Bone plain = test::MakeSphere({0, 0, 0}, 5, 0.2);
  Bone bone = MakeSharedSphere();
  const std::uint64_t hash = bone.CalcHash();
  Bone copy = CopySharing(bone);
  CutHalf(plain);
  CutHalf(copy);
  EXPECT_EQ(bone.CalcHash(), hash);
  EXPECT_EQ(copy.CalcHash(), plain.CalcHash());
  EXPECT_EQ(copy.CalcVolume(), plain.CalcVolume());
  EXPECT_EQ(copy.CountActiveVoxels(), plain.CountActiveVoxels());
  // The two fields are those of the plain bone, as its files store them.
  EXPECT_EQ(GridsOf(copy).whole->constTree().leafCount(), GridsOf(plain).whole->constTree().leafCount());
  for (auto leaf = GridsOf(plain).whole->constTree().cbeginLeaf(); leaf; ++leaf) {
    EXPECT_EQ(*GridsOf(copy).whole->constTree().probeConstLeaf(leaf->origin()), *leaf);
    EXPECT_EQ(*GridsOf(copy).cut->constTree().probeConstLeaf(leaf->origin()),
              *GridsOf(plain).cut->constTree().probeConstLeaf(leaf->origin()));
  }
  // The half with x < 0, four leaves wide, is left, and the leaves that the cut did not reach are still shared.
  EXPECT_GT(CountShared(bone, copy), CountLeaves(bone) / 3);
  // What was cut is never shared: a second session continues with it.
  ShareLeaves(plain);
  Bone next = CopySharing(plain);
  CutHalf(next);
  EXPECT_EQ(next.CalcHash(), copy.CalcHash());
  EXPECT_EQ(plain.CalcHash(), copy.CalcHash());
}

TEST(SharedLeaves, OutliveTheBoneThatWasCopied) {
  std::optional<Bone> bone = MakeSharedSphere();
  const std::uint64_t hash = bone->CalcHash();
  const Bone copy = CopySharing(*bone);
  CutHalf(*bone);
  bone.reset();
  EXPECT_EQ(copy.CalcHash(), hash);
}

}  // namespace
}  // namespace kerf
