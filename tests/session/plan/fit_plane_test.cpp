#include "session/plan/fit_plane.h"

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

#include "kerf/error.h"
#include "perfect_cut.h"
#include "session/plan/moments.h"
#include "support/cuts.h"

namespace kerf {
namespace {

using namespace plan_test;

void ExpectPlane(const std::optional<FittedPlane>& found, const CutPlane& cut, double mm, double deg) {
  ASSERT_TRUE(found);
  EXPECT_NEAR(glm::dot(cut.normal_W, found->p_W_mm - cut.p_W), 0, mm);
  EXPECT_LT(CalcAngle(found->normal_W, cut.normal_W), deg);
  EXPECT_NEAR(glm::length(found->normal_W), 1, 1e-12);
}

// Linear interpolation of a distance to a plane is exact except at the ridge. The remaining error is from the corners
// of the kerf: a fraction of a voxel at a few of the hundreds of centres.
TEST(FitKerf, FindsAPerfectCutInAnyPose) {
  Draw draw(1);
  for (int i = 0; i < 12; ++i) {
    SCOPED_TRACE(i);
    const Pose X = draw.AnyPose();
    const Bone before = MakeBlock(BlockAt(X, 0.2), test::OneRegionTable());
    Bone after = before;
    // The kerf goes through the whole block, at an angle to the faces.
    const Vec3 tilted = glm::normalize(Vec3(1, draw.In(-0.5, 0.5), draw.In(-0.5, 0.5)));
    const CutPlane cut{X.Point({draw.In(-3, 3), 0, -4}), X.Vector(tilted)};
    const double width = draw.In(0.25, 1);
    CutKerf(after, cut, width);
    const auto found = FitKerf(before, after);
    ExpectPlane(found, cut, 0.02, 0.1);
    EXPECT_NEAR(found->width_mm, width, 0.04);
    EXPECT_LT(found->rms_mm, 0.03);
    const double lost = before.CalcVolume() - after.CalcVolume();
    EXPECT_NEAR(found->volume_mm3, lost, 1e-6 * before.CalcVolume());
  }
}

TEST(FitKerf, FindsAGrooveOfADisc) {
  Draw draw(2);
  for (int i = 0; i < 12; ++i) {
    SCOPED_TRACE(i);
    const Pose X = draw.AnyPose();
    const Bone before = MakeBlock(BlockAt(X, 0.2), test::OneRegionTable());
    Bone after = before;
    const CutPlane cut{X.Point({draw.In(-2, 2), draw.In(-1, 1), 4}),
                       X.Vector(glm::normalize(Vec3(1, draw.In(-0.3, 0.3), draw.In(-0.3, 0.3))))};
    CutKerf(after, cut, 0.4, draw.In(7, 9));
    ExpectPlane(FitKerf(before, after), cut, 0.1, 0.1);
  }
}

// With voxels of 0.4 mm and a kerf of 0.25 mm, there may be no voxel centre in the kerf.
TEST(FitKerf, FindsAKerfThinnerThanAVoxel) {
  Draw draw(3);
  for (int i = 0; i < 8; ++i) {
    SCOPED_TRACE(i);
    Pose X = draw.AnyPose();
    if (i == 0) X = Pose{};
    if (i == 1) X = Pose{.R_AB = {1, 0, 0, 0}, .p_AB = {0.2, 0, 0}};  // midway between two layers
    const Bone before = MakeBlock(BlockAt(X, 0.4), test::OneRegionTable());
    Bone after = before;
    const CutPlane cut{X.Point({0, 0, -4}), X.Vector({1, 0, 0})};
    CutKerf(after, cut, 0.25);
    ExpectPlane(FitKerf(before, after), cut, 0.1, 0.1);
  }
}

// A kerf many voxels wide, as of a thick bur. The midpoints are exact, as above.
TEST(FitKerf, FindsAKerfManyVoxelsWide) {
  Draw draw(4);
  for (const auto& [width_mm, voxel_mm] : {std::pair(1.6, 0.1), std::pair(2.1, 0.125), std::pair(3.0, 0.2)}) {
    SCOPED_TRACE(width_mm);
    const Pose X = draw.AnyPose();
    const Bone before = MakeBlock(BlockAt(X, voxel_mm), test::OneRegionTable());
    Bone after = before;
    const CutPlane cut{X.Point({draw.In(-3, 3), 0, -4}),
                       X.Vector(glm::normalize(Vec3(1, draw.In(-0.3, 0.3), draw.In(-0.3, 0.3))))};
    CutKerf(after, cut, width_mm);
    const auto found = FitKerf(before, after);
    ExpectPlane(found, cut, 0.02, 0.1);
    EXPECT_NEAR(found->width_mm, width_mm, 0.04);
    EXPECT_GT(found->midpoints, 0);
  }
}

// A slightly curved kerf in bone that is high at one end and a narrow strip, with a tenth of the midpoints, at the
// other. The least-squares plane of the kerf's middle is computed without kerf: over the bone, 1.25 voxels inside it.
TEST(FitKerf, KeepsAnEndWithLittleBone) {
  constexpr double kVoxel_mm = 0.2;
  constexpr double kInside_mm = 1.25 * kVoxel_mm;
  const auto calc_middle = [](double x) { return 0.002 * (x + 8) * (x + 8); };
  constexpr double kStrip_mm[2] = {-2, -7.05};  // where it begins, and its top
  Bone before = MakeBlock(BlockAt({}, kVoxel_mm), test::OneRegionTable());
  Subtract(before, [&](const Vec3& p) { return std::max(kStrip_mm[0] - p.x, kStrip_mm[1] - p.z); });
  Bone after = before;
  Subtract(after, [&](const Vec3& p) { return std::abs(p.y - calc_middle(p.x)) - 0.2; });
  std::vector<WeightedPoint> middle;
  constexpr double kStep_mm = 0.02;
  for (double x = -8 + kInside_mm; x < 8 - kInside_mm; x += kStep_mm) {
    const double top_mm = x < kStrip_mm[0] - kInside_mm ? 0 : kStrip_mm[1];
    for (double z = -8 + kInside_mm; z < top_mm - kInside_mm; z += kStep_mm) {
      middle.push_back({Vec3(x, calc_middle(x), z), 1});
    }
  }
  const MomentFit wanted = FitMoments(middle).value();
  ExpectPlane(FitKerf(before, after), {wanted.p, wanted.normal}, 0.02, 0.1);
}

TEST(FitKerf, FindsTheSimulatedCut) {
  int i = 0;
  for (const Pose& X : test::BlockPoses(0.2)) {
    SCOPED_TRACE(i++);
    const Bone before = MakeBlock(BlockAt(X, 0.2), test::OneRegionTable());
    SimulationParams params;
    params.tool = DiscSaw{.diameter_mm = 16, .thickness_mm = 0.4};
    Simulation simulation(before, params, test::DiscPose(X, {-3, 0, 9}));
    test::Stroke(simulation, X, {-3, 0, 9}, {-3, 0, 3}, 100);
    test::Stroke(simulation, X, {-3, 0, 3}, {3, 0, 3}, 100);
    const auto found = FitKerf(before, simulation.UpdateBone());
    ExpectPlane(found, {X.Point({0, 0, 0}), X.Vector({0, 1, 0})}, 0.1, 0.1);
    EXPECT_NEAR(found->width_mm, 0.4, 0.05);
  }
}

TEST(FitKerf, DistinguishesTwoKerfs) {
  const Bone before = MakeBlock(BlockAt({}, 0.2), test::OneRegionTable());
  Bone after = before;
  const CutPlane first{{-4, 0, -4}, glm::normalize(Vec3(1, 0.1, 0.05))};
  const CutPlane second{{3, 0, -4}, glm::normalize(Vec3(1, -0.2, 0.1))};
  CutKerf(after, first, 0.4);
  CutKerf(after, second, 0.4);
  for (const CutPlane& cut : {first, second}) {
    KerfSearch search;
    search.near = CutPlane{cut.p_W + Vec3(0.8, 0, 0), {1, 0, 0}};
    search.reach_mm = 3;
    const auto found = FitKerf(before, after, search);
    ExpectPlane(found, cut, 0.1, 0.1);
    EXPECT_GT(glm::dot(found->normal_W, cut.normal_W), 0);
    Box3 within;
    within.Include(cut.p_W - Vec3(3, 10, 10));
    within.Include(cut.p_W + Vec3(3, 10, 10));
    ExpectPlane(FitKerf(before, after, within), cut, 0.1, 0.1);
  }
  // When all of the bone is searched, the fit is one of the kerfs, not a mean.
  const auto any = FitKerf(before, after);
  ASSERT_TRUE(any);
  const auto off = [&](const CutPlane& cut) {
    return std::abs(glm::dot(cut.normal_W, any->p_W_mm - cut.p_W)) + CalcAngle(any->normal_W, cut.normal_W);
  };
  EXPECT_LT(std::min(off(first), off(second)), 0.2);
}

TEST(FitKerf, IgnoresARemovedPiece) {
  const Bone before = MakeBlock(BlockAt({}, 0.2), test::OneRegionTable());
  Bone after = before;
  const CutPlane cut{{0, 0, -4}, glm::normalize(Vec3(1, 0.1, 0.05))};
  CutKerf(after, cut, 0.4);
  Subtract(after, [](const Vec3& p) { return glm::length(p - Vec3(6, 2, 0)) - 1.5; });
  ExpectPlane(FitKerf(before, after), cut, 0.1, 0.1);
}

// A shaving has only one side, so the fit is the mean of the lost volume.
TEST(FitKerf, FitsAShavingByItsVolume) {
  const Bone before = MakeBlock(BlockAt({}, 0.2), test::OneRegionTable());
  Bone after = before;
  Subtract(after, [](const Vec3& p) { return std::abs(p.z) - 0.5; });  // the upper half millimetre
  const auto found = FitKerf(before, after);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->midpoints, 0);
  EXPECT_LT(CalcAngle(found->normal_W, {0, 0, 1}), 0.1);
  EXPECT_NEAR(found->p_W_mm.z, -0.25, 0.05);
  EXPECT_NEAR(found->volume_mm3, 16 * 10 * 0.5, 1);
}

TEST(FitKerf, ReturnsNoneWithoutLossAndForABall) {
  const Bone before = MakeBlock(BlockAt({}, 0.25), test::OneRegionTable());
  EXPECT_FALSE(FitKerf(before, before));
  Bone after = before;
  Subtract(after, [](const Vec3& p) { return glm::length(p - Vec3(0, 0, -4)) - 2; });
  EXPECT_FALSE(FitKerf(before, after));
}

TEST(FitKerf, StatesTheMeasuresOfASlotThatIsTooShallowForAPlane) {
  const Bone before = MakeBlock(BlockAt({}, 0.2), test::OneRegionTable());
  constexpr double kSlot_mm[] = {8, 2.5, 2.1};  // length, depth, width
  Bone after = before;
  Subtract(after, [&](const Vec3& p) {
    return std::max({std::abs(p.x) - 0.5 * kSlot_mm[0], -kSlot_mm[1] - p.z, std::abs(p.y) - 0.5 * kSlot_mm[2]});
  });
  NoKerf why;
  ASSERT_FALSE(FitKerf(before, after, {}, &why));
  // The edges of the slot are rounded by a fraction of a voxel.
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(why.extents_mm[i], kSlot_mm[i], 0.1) << i;
  EXPECT_NEAR(why.removed_mm3, kSlot_mm[0] * kSlot_mm[1] * kSlot_mm[2], 0.02 * 8 * 2.5 * 2.1);
  EXPECT_GE(why.least_second_mm, 1.5 * why.extents_mm[2]);
  EXPECT_FALSE(FitKerf(before, before, {}, &why));
  EXPECT_EQ(why.removed_mm3, 0);
}

TEST(FitKerf, RefusesTwoDifferentBones) {
  const Bone fine = MakeBlock(BlockAt({}, 0.25), test::OneRegionTable());
  const Bone coarse = MakeBlock(BlockAt({}, 0.5), test::OneRegionTable());
  EXPECT_THROW(FitKerf(fine, coarse), Error);
}

}  // namespace
}  // namespace kerf
