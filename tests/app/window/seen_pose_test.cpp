#include "app/window/seen_pose.h"

#include <gtest/gtest.h>

#include "session/run/clear_pose.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// A ball of 10 mm around the origin, seen from the front by a window of 800 x 600 pixels, 0.1 mm each.
class SeenPose : public ::testing::Test {
 protected:
  SeenPose() {
    camera_.SetSize(800, 600);
    camera_.set_parallel(true);
    camera_.Look({0, -1, 0}, {0, 0, 1});
    camera_.set_height_mm(60);
  }
  Pose Find(const Vec3& home_W) const {
    return FindSeenPose(camera_, area_, phi_, bounds_W_, tool_, {{1, 0, 0, 0}, home_W});
  }

  Bone bone_ = test::MakeSphere({0, 0, 0}, 10, 0.5);
  PhiSampler phi_{bone_};
  Box3 bounds_W_ = bone_.CalcBounds();
  Tool tool_ = DiscSaw{};
  ViewCamera camera_;
  ScreenBox area_{200, 0, 600, 600};
};

TEST_F(SeenPose, IsTheHomeIfItIsSeen) {
  EXPECT_EQ(Find({2, -25, 3}).p_AB, Vec3(2, -25, 3));
  camera_.set_parallel(false);
  EXPECT_EQ(Find({2, -25, 3}).p_AB, Vec3(2, -25, 3));
}

TEST_F(SeenPose, IsInFrontOfTheBoneInTheMiddleOfTheAreaOtherwise) {
  const double reach_mm = CalcReach(tool_);
  for (const bool parallel : {true, false}) {
    camera_.set_parallel(parallel);
    // Far to the side, above the area, under a panel, behind the bone, and behind the eye.
    for (const Vec3& home : {Vec3{200, 0, 0}, Vec3{0, 0, 80}, Vec3{-38, -25, 0}, Vec3{0, 25, 0}, Vec3{0, -3000, 60}}) {
      const Pose X = Find(home);
      const auto at = camera_.Project(X.p_AB);
      ASSERT_TRUE(at);
      EXPECT_NEAR(at->x, 500, 1) << home.x << " " << home.y << " " << home.z;
      EXPECT_NEAR(at->y, 300, 1);
      EXPECT_TRUE(IsClear(phi_, tool_, X, 0));
      EXPECT_LT(X.p_AB.y, 0) << "on the side of the eye";
      EXPECT_LT(glm::length(X.p_AB), 10 + reach_mm + 12) << "near the bone";
    }
  }
}

}  // namespace
}  // namespace kerf
