// Tests that a tool that replaces another one begins with its edge at the same place.
#include "app/window/keep_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bone/grid/removed.h"
#include "bone/models/block.h"
#include "cut/tool/shape.h"
#include "session/run/clear_pose.h"

namespace kerf {
namespace {

Bone MakeTestBlock() {
  BlockParams block;
  block.size_mm = {40, 40, 10};
  block.voxel_mm = 0.5;
  return MakeBlock(block);
}

/// A disc 2 mm above the middle of the block's top, which lies at z = 0; its plane is x = 0.
Pose MakeDiscPose(const DiscSaw& disc) {
  return {glm::angleAxis(std::numbers::pi / 2, Vec3(0, 1, 0)), {0, 0, 2 + 0.5 * disc.diameter_mm}};
}

/// Returns the lowest point of the edge: that which is nearest to the top of the block.
Vec3 FindLowest(const Tool& tool, const Pose& X_WT) {
  return X_WT.Point(FindDeepest(tool, X_WT.InverseVector({0, 0, -1})));
}

TEST(KeepEdge, AnyToolTakesUpThePlaceAndTheDirectionOfTheDisc) {
  const Bone bone = MakeTestBlock();
  const DiscSaw disc;
  const Pose X_disc = MakeDiscPose(disc);
  for (const Tool& tool : GetDefaultTools()) {
    const Pose X_WT = KeepEdge(bone, disc, X_disc, tool);
    // A disc's rim is sampled 16 times for each of its teeth, here at every 1.8 mm: at most 0.04 mm above its lowest.
    EXPECT_NEAR(glm::distance(FindLowest(tool, X_WT), Vec3(0, 0, 2)), 0, 0.1) << GetShape(tool);
    if (CalcStroke(tool) > 0) {
      EXPECT_NEAR(X_WT.Vector({1, 0, 0}).z, -1, 0.01) << GetShape(tool);
      EXPECT_NEAR(std::abs(X_WT.Vector({0, 0, 1}).x), 1, 0.01) << "the same plane";
    } else if (!IsBlade(tool)) {
      EXPECT_NEAR(X_WT.Vector({0, 0, 1}).z, 1, 0.01) << GetShape(tool);
    }
    // And back.
    const Pose X_back = KeepEdge(bone, tool, X_WT, disc);
    EXPECT_NEAR(glm::distance(FindLowest(disc, X_back), Vec3(0, 0, 2)), 0, 0.1) << GetShape(tool);
  }
}

TEST(KeepEdge, SameToolStaysWhereItIs) {
  const Bone bone = MakeTestBlock();
  for (const Tool& tool : GetDefaultTools()) {
    const Pose X_WT{glm::normalize(Quat(0.9, 0.2, -0.3, 0.1)), {3, -4, 40}};
    const Pose X_same = KeepEdge(bone, tool, X_WT, tool);
    EXPECT_NEAR(glm::distance(X_same.p_AB, X_WT.p_AB), 0, 1e-9) << GetShape(tool);
    EXPECT_EQ(X_same.R_AB, X_WT.R_AB);
  }
}

TEST(KeepEdge, LeavesTheBoneByTheNearestWay) {
  const Bone bone = MakeTestBlock();
  const DiscSaw disc;
  Pose X_disc = MakeDiscPose(disc);
  X_disc.p_AB.z -= 4;  // 2 mm deep in the bone
  for (const Tool& tool : GetDefaultTools()) {
    const Pose X_WT = KeepEdge(bone, disc, X_disc, tool);
    EXPECT_TRUE(IsClear(PhiSampler(bone), tool, X_WT, 0.4)) << GetShape(tool);
    // 2 mm to the surface, a voxel of air, and steps of half a millimetre.
    EXPECT_LT(glm::distance(FindLowest(tool, X_WT), Vec3(0, 0, -2)), 2 + 0.5 + 1) << GetShape(tool);
  }
}

}  // namespace
}  // namespace kerf
