#include "session/plan/cut_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "kerf/error.h"
#include "perfect_cut.h"
#include "session/plan/edit_plane.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using plan_test::Subtract;
using test::MessageOf;
using ::testing::HasSubstr;

constexpr double kBarVoxel_mm = 0.2;
constexpr double kSampleStep_mm = 0.25;

/// A block of 16 x 10 x 8 mm with a plane across its length: 80 mm^2 of bone.
struct Bar {
  explicit Bar(const Pose& X = {}) : X_WB(X), before(test::MakeBox(X, {16, 10, 8}, kBarVoxel_mm)), now(before) {}

  PlannedPlane Plane(double offset_mm = 0) const {
    return {.name = "p",
            .plane = {X_WB.Point({offset_mm, 0, 0}), X_WB.Vector({1, 0, 0})},
            .margin_mm = 1,
            .width_mm = 20,
            .height_mm = 20,
            .up_W = X_WB.Vector({0, 0, 1})};
  }
  /// Removes a kerf of 0.4 mm at x = at_mm where keep(y, z) is positive, a distance to the bone that stays.
  void Cut(double at_mm, const std::function<double(double y, double z)>& keep) {
    Subtract(now, [&](const Vec3& p_W) {
      const Vec3 p = X_WB.InversePoint(p_W);
      return std::max(std::abs(p.x - at_mm) - 0.2, -keep(p.y, p.z));
    });
  }

  Pose X_WB;
  Bone before;
  Bone now;
};

// An area is counted in samples: half a step along each border. The borders themselves are placed to a tenth of a
// voxel.
double AreaError(double border_mm) {
  return border_mm * (0.5 * kSampleStep_mm + 0.1 * kBarVoxel_mm);
}

TEST(CutState, OfAnUncutAndOfASeparatedBlock) {
  for (const Pose& X : {Pose{}, test::BlockPoses(kBarVoxel_mm)[5]}) {
    Bar bar(X);
    const CutState whole = CalcCutState(bar.before, bar.now, bar.Plane());
    EXPECT_NEAR(whole.before_mm2, 80, AreaError(36));
    EXPECT_EQ(whole.left_mm2, whole.before_mm2);
    EXPECT_EQ(whole.fraction(), 0);
    ASSERT_EQ(whole.bridges.size(), 1u);
    EXPECT_NEAR(glm::length(whole.bridges[0].centre_W - X.p_AB), 0, kSampleStep_mm);
    bar.Cut(0, [](double, double) { return 1e9; });
    const CutState cut = CalcCutState(bar.before, bar.now, bar.Plane());
    EXPECT_EQ(cut.before_mm2, whole.before_mm2);
    EXPECT_EQ(cut.left_mm2, 0);
    EXPECT_EQ(cut.fraction(), 1);
    EXPECT_TRUE(cut.bridges.empty());
  }
}

TEST(CutState, IsAHalfWhereHalfIsCut) {
  for (const Pose& X : {Pose{}, test::BlockPoses(kBarVoxel_mm)[4], test::BlockPoses(kBarVoxel_mm)[6]}) {
    Bar bar(X);
    bar.Cut(0, [](double, double z) { return z; });  // the upper half
    const CutState state = CalcCutState(bar.before, bar.now, bar.Plane());
    EXPECT_NEAR(state.fraction(), 0.5, AreaError(10 + 8) / 80);
    ASSERT_EQ(state.bridges.size(), 1u);
    const Bridge& bridge = state.bridges[0];
    EXPECT_NEAR(bridge.area_mm2, 40, AreaError(28));
    EXPECT_NEAR(glm::length(X.InversePoint(bridge.centre_W) - Vec3(0, 0, -2)), 0, kSampleStep_mm);
    // The patches cover the area exactly and lie in the plane.
    double covered = 0;
    for (const auto& patch : bridge.patches) {
      covered += glm::length(glm::cross(patch[1] - patch[0], patch[3] - patch[0]));
      for (const Vec3& p : patch) {
        EXPECT_NEAR(X.InversePoint(p).x, 0, 1e-9);
        EXPECT_LE(X.InversePoint(p).z, 0.5 * kSampleStep_mm + 0.1 * kBarVoxel_mm);
      }
    }
    EXPECT_NEAR(covered, bridge.area_mm2, 1e-9 * covered);
  }
}

TEST(CutState, FindsTheTabsThatAreLeft) {
  // Two tabs of 2 x 3 and 1.5 x 2 mm inside the block.
  const auto tabs = [](double y, double z) {
    const auto box = [](double u, double v, double width, double height) {
      return std::max(std::abs(u) - 0.5 * width, std::abs(v) - 0.5 * height);
    };
    return std::min(box(y + 3, z - 1, 2, 3), box(y - 2.5, z + 2, 1.5, 2));
  };
  for (const Pose& X : {Pose{}, test::BlockPoses(kBarVoxel_mm)[5]}) {
    Bar bar(X);
    bar.Cut(0, tabs);
    const CutState state = CalcCutState(bar.before, bar.now, bar.Plane());
    ASSERT_EQ(state.bridges.size(), 2u);
    EXPECT_NEAR(state.bridges[0].area_mm2, 6, AreaError(10));
    EXPECT_NEAR(state.bridges[1].area_mm2, 3, AreaError(7));
    EXPECT_NEAR(glm::length(X.InversePoint(state.bridges[0].centre_W) - Vec3(0, -3, 1)), 0, kSampleStep_mm);
    EXPECT_NEAR(glm::length(X.InversePoint(state.bridges[1].centre_W) - Vec3(0, 2.5, -2)), 0, kSampleStep_mm);
    EXPECT_NEAR(state.left_mm2, state.bridges[0].area_mm2 + state.bridges[1].area_mm2, 1e-9);
    EXPECT_NEAR(state.fraction(), 1 - 9.0 / 80, AreaError(17) / 80);
    const Box3& extent = state.bridges[0].extent_W;
    EXPECT_LT(glm::length(extent.centre() - state.bridges[0].centre_W), kSampleStep_mm);
  }
}

TEST(CutState, CountsAKerfWithinTheMarginOnly) {
  for (const double offset : {-0.9, -0.5, 0.5, 0.9}) {
    Bar bar;
    bar.Cut(offset, [](double, double) { return 1e9; });
    EXPECT_EQ(CalcCutState(bar.before, bar.now, bar.Plane()).fraction(), 1) << offset;
  }
  for (const double offset : {-1.4, 1.4}) {  // the kerf's nearer side is 1.2 mm from the plane
    Bar bar;
    bar.Cut(offset, [](double, double) { return 1e9; });
    EXPECT_EQ(CalcCutState(bar.before, bar.now, bar.Plane()).fraction(), 0) << offset;
  }
}

TEST(CutState, TheBonesOwnSurfaceIsNoCut) {
  // The plane lies 0.3 mm inside the block's end, so that the margin of 1 mm reaches beyond its surface.
  const Bar bar;
  const CutState state = CalcCutState(bar.before, bar.now, bar.Plane(7.7));
  EXPECT_NEAR(state.before_mm2, 80, AreaError(36));
  EXPECT_EQ(state.fraction(), 0);
}

TEST(CutState, LooksOnlyAtTheRectangle) {
  Bar bar;
  bar.Cut(0, [](double, double z) { return z; });
  PlannedPlane plane = MovePlane(bar.Plane(), {0, 2, 0});
  plane.height_mm = 4;  // the upper half
  EXPECT_EQ(CalcCutState(bar.before, bar.now, plane).fraction(), 1);
  plane = MovePlane(plane, {0, -4, 0});  // the lower half
  EXPECT_EQ(CalcCutState(bar.before, bar.now, plane).fraction(), 0);
  plane = MovePlane(plane, {0, 0, 100});
  EXPECT_EQ(CalcCutState(bar.before, bar.now, plane).before_mm2, 0);
  EXPECT_EQ(CalcCutState(bar.before, bar.now, plane).fraction(), 0);
}

TEST(CutState, RefusesOtherBonesAndOptions) {
  const Bar bar;
  const Bone coarse = test::MakeBox({}, {16, 10, 8}, 0.4);
  EXPECT_THAT(MessageOf([&] { CalcCutState(bar.before, coarse, bar.Plane()); }), HasSubstr("must be the same bone"));
  EXPECT_THAT(MessageOf([&] { CalcCutState(bar.before, bar.now, bar.Plane(), {.step_mm = 0}); }),
              HasSubstr("must be above 0"));
}

}  // namespace
}  // namespace kerf
