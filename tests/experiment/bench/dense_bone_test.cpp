// Tests of the brute-force reference on solids with known volumes, independent of the code that is compared with it.
#include "experiment/bench/dense_bone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "kerf/error.h"
#include "support/message_of.h"
#include "support/solids.h"

namespace kerf {
namespace {

DenseBone MakeDenseBlock(double voxel_mm, double half_mm = 6) {
  const Bone block = test::MakeBox(Pose{}, Vec3(2 * half_mm), voxel_mm);
  return DenseBone(block, Box3{Vec3(-half_mm - 1), Vec3(half_mm + 1)});
}

TEST(DenseBone, ContainsTheValuesOfTheBone) {
  const Bone block = test::MakeBox(Pose{}, {4, 5, 6}, 0.25);
  const DenseBone dense(block, Box3{Vec3(-4), Vec3(4)});
  EXPECT_EQ(dense.size(), (std::array<int, 3>{33, 33, 33}));
  EXPECT_EQ(dense.Compare(block).voxels, 0u);
  // The occupancy of a half space is linear in the position of its face. The only error is at the block's edges: a
  // fraction of h^2 times their length of 60 mm.
  EXPECT_NEAR(dense.CalcOccupancy_mm3(), 120, 60 * 0.25 * 0.25 / 4);
}

TEST(DenseBone, BallOnAStraightPathRemovesACapsule) {
  const BallBurr ball{.diameter_mm = 6};
  for (const double h : {0.3, 0.15}) {
    DenseBone dense = MakeDenseBlock(h);
    const double before = dense.CalcOccupancy_mm3();
    Pose from;
    Pose to;
    from.p_AB = {-0.7, 0.2, 0.1};
    to.p_AB = {0.9, -0.3, 0.4};
    dense.Cut(ball, from, to);
    const double length = glm::length(to.p_AB - from.p_AB);
    const double capsule = std::numbers::pi * 27 * 4 / 3 + std::numbers::pi * 9 * length;
    // At a curved face the error of the occupancy is h^2/24 times the integral of the sum of the principal curvatures
    // (2/r on the ball, 1/r along the tube): 8 pi r + 2 pi length. The tolerance includes the sampling of the face by
    // the grid.
    EXPECT_NEAR(before - dense.CalcOccupancy_mm3(), capsule,
                h * h / 12 * (8 * std::numbers::pi * 3 + 2 * std::numbers::pi * length))
        << h;
  }
}

TEST(DenseBone, DiscMovingInItsPlaneRemovesAStadium) {
  DiscSaw saw;
  saw.diameter_mm = 8;
  saw.thickness_mm = 1;
  const double h = 0.125;
  DenseBone dense = MakeDenseBlock(h);
  const double before = dense.CalcOccupancy_mm3();
  Pose from;
  from.R_AB = glm::angleAxis(0.6, glm::normalize(Vec3(1, 2, 0.5)));
  Pose to = from;
  to.p_AB = from.Vector({1.1, -0.4, 0});
  dense.Cut(saw, from, to);
  const double length = glm::length(to.p_AB);
  const double stadium = (std::numbers::pi * 16 + 8 * length) * 1;
  const double edges = 2 * (2 * std::numbers::pi * 4 + 2 * length);
  // The flats are exact; at the two edges of the rim the error is up to h^2 / 4 per unit of length.
  EXPECT_NEAR(before - dense.CalcOccupancy_mm3(), stadium, edges * h * h / 4);
}

TEST(DenseBone, MotionAlongTheSpindleIsLeftOut) {
  const DiscSaw saw{.diameter_mm = 8, .thickness_mm = 1};
  DenseBone a = MakeDenseBlock(0.25);
  DenseBone b = a;
  Pose from;
  Pose to;
  from.p_AB = {0, 0, 0.5};
  a.Cut(saw, from, to);
  b.Cut(saw, to, to);
  EXPECT_EQ(a.CalcOccupancy_mm3(), b.CalcOccupancy_mm3());
}

TEST(DenseBone, CuttingTwiceChangesNothingMore) {
  const BallBurr ball{.diameter_mm = 4};
  DenseBone dense = MakeDenseBlock(0.25);
  Pose to;
  to.p_AB = {1, 0, 0};
  dense.Cut(ball, Pose{}, to);
  const double once = dense.CalcOccupancy_mm3();
  dense.Cut(ball, Pose{}, to);
  EXPECT_EQ(dense.CalcOccupancy_mm3(), once);
}

TEST(DenseBone, DifferenceIsWhatWasCut) {
  const Bone block = test::MakeBox(Pose{}, Vec3(12), 0.25);
  DenseBone dense(block, Box3{Vec3(-7), Vec3(7)});
  const double before = dense.CalcOccupancy_mm3();
  dense.Cut(BallBurr{.diameter_mm = 4}, Pose{}, Pose{});
  const DenseDifference difference = dense.Compare(block);
  EXPECT_NEAR(difference.volume_mm3, before - dense.CalcOccupancy_mm3(), 1e-9);
  EXPECT_NEAR(difference.max_phi_mm, 2 * block.band_mm(), 1e-6);  // from solid bone to well outside
}

TEST(DenseBone, RefusesAnEmptyBoxAndAnotherGrid) {
  const Bone block = test::MakeBox(Pose{}, Vec3(4), 0.25);
  EXPECT_EQ(test::MessageOf([&] { const DenseBone dense(block, Box3{}); }),
            "a dense copy of the bone would have 0 voxels; valid range 1 to 2^31");
  const DenseBone dense(block, Box3{Vec3(-1), Vec3(1)});
  EXPECT_EQ(test::MessageOf([&] { dense.Compare(test::MakeBox(Pose{}, Vec3(4), 0.5)); }),
            "bones with voxels of 0.25 and 0.5 mm can't be compared voxel by voxel");
}

}  // namespace
}  // namespace kerf
