#include "app/window/mark_place.h"

#include <gtest/gtest.h>

#include "kerf/models.h"

namespace kerf {
namespace {

TEST(MarkPlace, ANerveMayLieInSoftTissueButNotInAir) {
  BlockParams params;
  params.size_mm = {10, 10, 10};
  params.voxel_mm = 0.5;
  const Bone block = MakeBlock(params);
  const double top_mm = block.CalcBounds().upper.z;
  const Vec3 near_W{0, 0, top_mm + 1.5}, far_W{0, 0, top_mm + 3}, in_W{0, 0, top_mm - 5};
  const CtSource tissue = [](const Vec3&) { return 40.0; };
  const CtSource air = [](const Vec3&) { return -1000.0; };
  EXPECT_EQ(FindMarkPlace(block, tissue, MarkKind::kNerve, far_W), MarkPlace::kUsual);
  EXPECT_EQ(FindMarkPlace(block, air, MarkKind::kNerve, far_W), MarkPlace::kInAir);
  EXPECT_EQ(FindMarkPlace(block, tissue, MarkKind::kTooth, far_W), MarkPlace::kFarFromBone);
  EXPECT_EQ(FindMarkPlace(block, tissue, MarkKind::kTooth, near_W), MarkPlace::kUsual);
  EXPECT_EQ(FindMarkPlace(block, tissue, MarkKind::kTooth, in_W), MarkPlace::kUsual);
  // Without a CT, nothing is known but the bone.
  EXPECT_EQ(FindMarkPlace(block, nullptr, MarkKind::kNerve, far_W), MarkPlace::kFarFromBone);
  EXPECT_EQ(FindMarkPlace(block, nullptr, MarkKind::kNerve, near_W), MarkPlace::kUsual);
}

}  // namespace
}  // namespace kerf
