// Tests that compare swept volumes with closed forms and with brute force.
#include <gtest/gtest.h>

#include <random>
#include <utility>

#include "experiment/reference/cuts.h"
#include "support/saw.h"

namespace kerf {
namespace {

using namespace test;

TEST(ExactBone, SlotIsAStadiumAsThickAsTheDisc) {
  ExactBone bone(Block({}, {60, 20, 60}), kSaw);
  constexpr int kSteps = 700;
  for (int i = 0; i < kSteps; ++i) {
    bone.Sweep(Upright({-5 + 10.0 * i / kSteps, 0, 1}), Upright({-5 + 10.0 * (i + 1) / kSteps, 0, 1}), 0);
  }
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = Vec3(20, 0.5, 16) * Vec3(unit(random), unit(random), unit(random));
    const double across = std::hypot(p.x - std::clamp(p.x, -5.0, 5.0), p.z - 1) - kR;
    const double along = std::abs(p.y) - 0.5 * kSaw.thickness_mm;
    const double outside = std::hypot(std::max(across, 0.0), std::max(along, 0.0));
    const double d = outside + std::min(std::max(across, along), 0.0);
    const Vec3 b = glm::abs(p) - 0.5 * Vec3(60, 20, 60);
    const double solid = std::max({b.x, b.y, b.z});
    if (d > 0) {
      EXPECT_NEAR(bone.Distance(p), std::max(solid, -d), 1e-9);
    } else {
      // Each step is itself a stadium, so the arc between two centres causes no error. On the path, a point is less
      // deep inside any single step than inside the union of all steps.
      EXPECT_GT(bone.Distance(p), -1e-9);
      EXPECT_LE(bone.Distance(p), -d + 1e-9);
    }
    if (std::abs(d) > 1e-6) {
      EXPECT_EQ(bone.IsBone(p), d > 0 && solid < 0);
      EXPECT_EQ(bone.IsSwept(p), d < 0);
    }
  }
}

TEST(ExactBone, GroupsAgreeWithSingleSweeps) {
  // A random path is swept with the whole disc, with the rim, and alternately with both. The expected result is the
  // union of the sweeps, computed from bones with one sweep each.
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto solid = [] { return Block({}, {200, 200, 200}); };
  for (const auto& [first_mm, second_mm] : {std::pair(0.0, 0.0), {0.4, 0.4}, {0.0, 0.4}}) {
    ExactBone all(solid(), kSaw);
    std::vector<ExactBone> each;
    Pose X = Upright({0, 0, 0});
    for (int i = 0; i < 150; ++i) {
      const double edge_mm = i % 20 == 0 ? first_mm : second_mm;
      Pose X_next = X;
      X_next.p_AB += 0.3 * Vec3(unit(random), 0.1 * unit(random), unit(random)) + X.Vector({0.2, 0, 0});
      X_next.R_AB = glm::normalize(X.R_AB * Quat(1, 0.02 * unit(random), 0.02 * unit(random), 0.1 * unit(random)));
      all.Sweep(X, X_next, edge_mm);
      each.emplace_back(solid(), kSaw);
      each.back().Sweep(X, X_next, edge_mm);
      X = X_next;
    }
    for (int i = 0; i < 400; ++i) {
      const Vec3 p = Vec3(30, 8, 18) * Vec3(unit(random), unit(random), unit(random));
      double largest = -1e9;
      for (const ExactBone& one : each) largest = std::max(largest, one.Distance(p));
      EXPECT_NEAR(all.Distance(p), largest, 1e-9);
    }
  }
}

TEST(ExactBone, StraightPathInPartsIsOneStadium) {
  // Sweeps the whole disc and the rim, rotated; then a bend, which does not belong to the straight path.
  const Pose X_WB{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, -0.5))), {3, 4, 5}};
  const auto at = [&](double x, double z) { return Times(X_WB, Upright({x, 0, z})); };
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double edge_mm : {0.0, 0.4}) {
    ExactBone parts(Block(X_WB, {200, 200, 200}), kSaw);
    ExactBone whole(Block(X_WB, {200, 200, 200}), kSaw);
    for (int i = 0; i < 500; ++i) parts.Sweep(at(0.01 * i, 0), at(0.01 * (i + 1), 0), edge_mm);
    whole.Sweep(at(0, 0), at(5, 0), edge_mm);
    for (ExactBone* bone : {&parts, &whole}) bone->Sweep(at(5, 0), at(6, 0.5), edge_mm);
    for (int i = 0; i < 2000; ++i) {
      const Vec3 p = X_WB.Point(Vec3(20, 0.4, 16) * Vec3(unit(random), unit(random), unit(random)));
      EXPECT_NEAR(parts.Distance(p), whole.Distance(p), 1e-9);
    }
  }
}

TEST(ExactBone, SlightlyBentPathIsNotStraightened) {
  ExactBone bone(Block({}, {200, 200, 200}), kSaw);
  for (int i = 0; i < 200; ++i) {
    const auto at = [](double turn) { return Upright({10 * std::sin(turn), 0, 10 * std::cos(turn)}); };
    bone.Sweep(at(0.005 * i), at(0.005 * (i + 1)), 0);
  }
  // Outside the bend, the chords of 0.05 mm lie 3e-5 mm inside the arc.
  EXPECT_NEAR(bone.Distance({21.5 * std::sin(0.5), 0, 21.5 * std::cos(0.5)}), -(21.5 - 10 - kR), 4e-5);
}

TEST(ExactBone, RimDoesNotRemoveTheInside) {
  ExactBone bone(Block({}, {60, 60, 60}), kSaw);
  bone.Sweep(Upright({0, 0, 0}), Upright({0.1, 0, 0}), 0.5);
  EXPECT_TRUE(bone.IsBone({0, 0, 0}));
  EXPECT_NEAR(bone.Distance({0, 0, 0}), -(kR - 0.5 - 0.1), 1e-12);  // to the rim of the disc at the end of the sweep
  EXPECT_FALSE(bone.IsBone({kR - 0.2, 0, 0}));
  EXPECT_TRUE(bone.IsBone({kR - 0.2, 0.2, 0}));
  EXPECT_NEAR(bone.Distance({kR - 0.2, 0.2, 0}), -(0.2 - 0.125), 1e-12);
  EXPECT_TRUE(bone.IsBone({kR + 0.11, 0, 0}));
}

TEST(ExactBone, BoundsContainTheSweepAndAirIsSkipped) {
  ExactBone bone(Block({}, {10, 10, 10}), kSaw);
  EXPECT_TRUE(bone.swept_bounds().empty());
  bone.Sweep(Upright({500, 0, 0}), Upright({501, 0, 0}), 0);
  EXPECT_TRUE(bone.swept_bounds().empty());
  bone.Sweep(Upright({0, 0, 0}), Upright({1, 0, 0}), 0);
  const Box3 box = bone.swept_bounds();
  EXPECT_NEAR(glm::length(box.lower - Vec3(-kR, -0.125, -kR)), 0, 1e-9);
  EXPECT_NEAR(glm::length(box.upper - Vec3(kR + 1, 0.125, kR)), 0, 1e-9);
}

/// Returns the area of the part of the segment (1 mm high, 9.17 mm long) that lies within the block's 8 mm.
double SegmentArea8() {
  constexpr int kIntervals = 10000;
  double area = 0;
  for (int i = 0; i < kIntervals; ++i) {
    const double x = -4 + 8 * (i + 0.5) / kIntervals;
    area += 8.0 / kIntervals * (std::sqrt(kR * kR - x * x) - (kR - 1));
  }
  return area;
}

TEST(ExactBone, RemovedVolumesMatchTheClosedForms) {
  // The block is rotated, so that no cell is aligned with a wall. Tests a kerf through the whole block, a plunge, and
  // both together.
  const Pose X_WB{glm::angleAxis(0.7, glm::normalize(Vec3(1, 2, -0.5))), {3, 4, 5}};
  const auto at = [&](double x, double z) { return Times(X_WB, Upright({x, 0, z})); };
  ExactBone slot(Block(X_WB, {8, 4, 12}), kSaw);
  slot.Sweep(at(-16, 4 + kR), at(16, 4 + kR), 0);
  EXPECT_NEAR(slot.CalcRemoved(1.0 / 32), 8 * 2 * 0.25, 1e-3 * 4);
  slot.Sweep(at(0, 4 + kR), at(0, 3 + kR), 0);  // 1 mm deeper: a segment
  EXPECT_NEAR(slot.CalcRemoved(1.0 / 32), 4 + 0.25 * SegmentArea8(), 1e-3 * 4);
  ExactBone plunge(Block(X_WB, {40, 4, 12}), kSaw);
  plunge.Sweep(at(0, 7 + kR), at(0, 4 + kR), 0);
  const double expected = SegmentArea(kR, 2) * 0.25;
  const double coarse = plunge.CalcRemoved(1.0 / 8) - expected;
  const double fine = plunge.CalcRemoved(1.0 / 32) - expected;
  EXPECT_LT(std::abs(fine), 1e-3 * expected);
  EXPECT_LT(std::abs(fine), 0.3 * std::abs(coarse));
}

}  // namespace
}  // namespace kerf
