// A drill in a hand: the wall of its hole holds it, its side does not cut, and it stops when bone ends.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cut/hand_sim/hands.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::Handle;
using test::PushingHand;

CoupledParams DrillParams() {
  CoupledParams params;
  TwistDrill drill;
  drill.diameter_mm = 2;
  drill.length_mm = 16;
  params.tool = drill;
  return params;
}

/// A plate 6 mm thick, with its top at z = 0 of the block's frame.
Bone Plate(const Pose& X_WB, double voxel_mm) {
  return test::MakeBox({X_WB.R_AB, X_WB.Point({0, 0, -3})}, {8, 8, 6}, voxel_mm);
}

/// A drill that has been pushed into the plate to a depth.
struct InHole {
  InHole(const Pose& the_X_WB, double voxel_mm, double depth_mm, const CoupledParams& params = DrillParams())
      : X_WB(the_X_WB),
        simulation(Plate(X_WB, voxel_mm), params, {X_WB.R_AB, X_WB.Point({0, 0, 0.1})}),
        hand(simulation, {X_WB.R_AB, X_WB.Point({0, 0, 0.1})}) {
    for (int i = 0; i < 20000 && Place().z > -depth_mm; ++i) out = hand.Push(X_WB.Vector({0, 0, -5}), 30000);
  }
  Vec3 Place() const { return X_WB.InversePoint(hand.X_WT().p_AB); }

  Pose X_WB;
  CoupledSimulation simulation;
  PushingHand hand;
  CoupledOutput out;
};

TEST(CoupledDrill, AHoleDoesNotResistAStraightFeed) {
  for (const double h : {0.1, 0.2}) {
    for (const std::size_t n : {0u, 3u, 5u, 6u}) {
      const Pose X_WB = BlockPoses(h)[n];
      CoupledSimulation simulation(Plate(X_WB, h), DrillParams(), {X_WB.R_AB, X_WB.Point({0, 0, 0.5})});
      double side_N = 0, hand_N = 0;
      for (int i = 0; i < 2000; ++i) {
        const CoupledOutput out = simulation.Tick(Handle({X_WB.R_AB, X_WB.Point({0, 0, 0.5 - 0.002 * i})}, 30000));
        side_N = std::max(side_N, glm::length(out.f_face_W_N));
        const Vec3 f_B_N = X_WB.InverseVector(out.f_H_W_N);
        hand_N = std::max(hand_N, std::hypot(f_B_N.x, f_B_N.y));
      }
      // Opposite points of the side share what the grid takes from the hole, so that it does not squeeze the drill. The
      // wall balances the small force across the axis of the lips' samples; none of it reaches the hand.
      EXPECT_LT(side_N, 0.5) << h << " " << n;
      EXPECT_LT(hand_N, 0.01) << h << " " << n;
    }
  }
}

TEST(CoupledDrill, TheWallOfTheHoleHoldsASidewaysPushAndIsNotCut) {
  for (const std::size_t n : {0u, 5u}) {
    InHole hole(BlockPoses(0.1)[n], 0.1, 4);
    ASSERT_LT(hole.Place().z, -3.9);
    const Vec3 before = hole.Place();
    const double removed_mm3 = hole.simulation.CalcRemovedByRegion()[24];
    for (int i = 0; i < 500; ++i) hole.out = hole.hand.Push(hole.X_WB.Vector({8, 0, 0}), 30000);
    // Some points of the side bear 8 N with 3000 N/mm each.
    EXPECT_LT(std::hypot(hole.Place().x - before.x, hole.Place().y - before.y), 0.02) << n;
    EXPECT_NEAR(hole.X_WB.InverseVector(hole.out.f_face_W_N).x, -8, 0.8) << n;
    // The ends of the lips cut as far as the drill yields and tilts.
    EXPECT_NEAR(hole.simulation.CalcRemovedByRegion()[24], removed_mm3, 0.02 * removed_mm3) << n;
  }
}

TEST(CoupledDrill, BreaksThroughAndPlungesOnlyAsFarAsTheHandFollows) {
  // With a constant push the drill runs through the far side. Its hole is a cylinder, and the bone then resists
  // nothing.
  InHole hole(BlockPoses(0.1)[5], 0.1, 7.5);
  hole.out = hole.hand.Push(hole.X_WB.Vector({0, 0, -5}), 30000);  // a tick after the one that broke through
  EXPECT_LT(hole.Place().z, -7.4);
  EXPECT_NEAR(hole.simulation.CalcRemovedByRegion()[24] / (std::numbers::pi * 6), 1, 0.015);
  EXPECT_EQ(hole.out.engaged_teeth, 0);
}

TEST(CoupledDrill, AStoppedDrillRestsOnBone) {
  const Pose X_WB = BlockPoses(0.1)[4];
  CoupledSimulation simulation(Plate(X_WB, 0.1), DrillParams(), {X_WB.R_AB, X_WB.Point({0, 0, 0.3})});
  PushingHand hand(simulation, {X_WB.R_AB, X_WB.Point({0, 0, 0.3})});
  CoupledOutput out;
  for (int i = 0; i < 2000; ++i) out = hand.Push(X_WB.Vector({0, 0, -5}), 0);
  EXPECT_EQ(simulation.CalcRemovedByRegion()[24], 0);
  EXPECT_GT(X_WB.InversePoint(hand.X_WT().p_AB).z, -0.1);
}

}  // namespace
}  // namespace kerf
