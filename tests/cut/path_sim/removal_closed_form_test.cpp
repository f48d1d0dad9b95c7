// Removed volume and kerf width, and their convergence, compared with closed forms, for many poses of the block in the
// grid.
#include <gtest/gtest.h>

#include <numeric>

#include "base/core/heap_guard.h"
#include "kerf/simulation.h"
#include "kerf/surface.h"
#include "support/cuts.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscPose;
using test::SegmentArea;
using test::Stroke;

constexpr double kDepth = 3;     // mm
const Vec3 kBlockSize(6, 3, 5);  // mm; the top face is at z = 2.5 in the block's frame
const double kTop = 0.5 * kBlockSize.z;

Bone Block(const Pose& X_WB, double voxel_mm) {
  return test::MakeBox(X_WB, kBlockSize, voxel_mm);
}

/// Returns the exact volume removed so far.
double Removed(Simulation& simulation) {
  const auto& by_region = simulation.CalcRemovedByRegion();
  return std::accumulate(by_region.begin(), by_region.end(), 0.0);
}

/// Returns the removed volume by occupancy, summed over the ticks.
double RemovedIn(const std::vector<TickOutput>& ticks) {
  return std::accumulate(ticks.begin(), ticks.end(), 0.0,
                         [](double sum, const TickOutput& t) { return sum + t.removed_mm3; });
}

/// Returns the height of the centre for which the lowest point of the rim is `depth` below the top face.
double CentreHeight(double depth) {
  return kTop - depth + kSaw.radius_mm();
}

/// Returns the volume of a kerf along x through the whole block: a cuboid.
double SlotVolume() {
  return kSaw.thickness_mm * kDepth * kBlockSize.x;
}

double CutSlot(Simulation& simulation, const Pose& X_WB) {
  const double z = CentreHeight(kDepth);
  Stroke(simulation, X_WB, {-11.5, 0, z}, {11.5, 0, z}, 100);
  return Removed(simulation);
}

Simulation MakeSlotSimulation(const Pose& X_WB, double voxel_mm) {
  return Simulation(Block(X_WB, voxel_mm), {}, DiscPose(X_WB, {-11.5, 0, CentreHeight(kDepth)}));
}

TEST(RemovalClosedForm, SlotVolumeIsWithinOnePercentInEveryPose) {
  for (const Pose& X_WB : BlockPoses(0.1)) {
    Simulation simulation = MakeSlotSimulation(X_WB, 0.1);
    EXPECT_NEAR(CutSlot(simulation, X_WB) / SlotVolume(), 1, 0.01);
  }
}

TEST(RemovalClosedForm, PlungeVolumeIsWithinOnePercentInEveryPose) {
  // The block is longer here, so that the chord (15 mm at this depth) stays inside its ends.
  const Vec3 size(17, 1.6, 4);
  for (const Pose& X_WB : BlockPoses(0.1)) {
    const double top = 0.5 * size.z;
    const Vec3 high(0, 0, top + kSaw.radius_mm() + 0.5);
    const Vec3 low(0, 0, top + kSaw.radius_mm() - kDepth);
    Simulation simulation(test::MakeBox(X_WB, size, 0.1), {}, DiscPose(X_WB, high));
    const double by_occupancy = RemovedIn(Stroke(simulation, X_WB, high, low, 10));
    const double expected = kSaw.thickness_mm * SegmentArea(kSaw.radius_mm(), kDepth);
    EXPECT_NEAR(Removed(simulation) / expected, 1, 0.01);
    // The ticks report the volume by occupancy, with a ramp one voxel wide: between the layers of centres that a wall
    // at 45 degrees meets, 0.71 voxels apart, it does not sum to a constant for all positions of the wall.
    EXPECT_NEAR(by_occupancy / expected, 1, 0.04);
    // Moving out again removes nothing.
    EXPECT_EQ(RemovedIn(Stroke(simulation, X_WB, low, high, 10)), 0);
  }
}

// A grid rounds off each of the two edges of the kerf's floor by about 0.15 h^2 of cross-section at any depth, which
// would be 1.5 % of a shallow plunge. The volume is computed from parts of a quarter of a voxel there, in which the
// rounding is a sixteenth.
TEST(RemovalClosedForm, ShallowPlungeKeepsTheEdgesOfItsFloor) {
  const Vec3 size(12, 1.6, 3);
  const double depth = 1.2;
  double lowest = 1, highest = -1, squares = 0;
  const double expected = kSaw.thickness_mm * SegmentArea(kSaw.radius_mm(), depth);
  const double chord_mm = 2 * std::sqrt(depth * (kSaw.diameter_mm - depth));
  for (const Pose& X_WB : BlockPoses(0.1)) {
    const double top = 0.5 * size.z;
    const Vec3 high(0, 0, top + kSaw.radius_mm() + 0.5);
    const Vec3 low(0, 0, top + kSaw.radius_mm() - depth);
    Simulation simulation(test::MakeBox(X_WB, size, 0.1), {}, DiscPose(X_WB, high));
    Stroke(simulation, X_WB, high, low, 10);
    const double error = Removed(simulation) / expected - 1;
    EXPECT_LT(std::abs(error), 0.25 * 2 * 0.15 * 0.1 * 0.1 * chord_mm / expected);  // 0.4 %
    squares += error * error / static_cast<double>(BlockPoses(0.1).size());
    lowest = std::min(lowest, error);
    highest = std::max(highest, error);
  }
  std::printf("plunge of 1.2 mm: volume %+.2f to %+.2f %%, rms %.2f %%\n", 100 * lowest, 100 * highest,
              100 * std::sqrt(squares));
}

TEST(RemovalClosedForm, SlotVolumeConvergesWithOrderAtLeastOnePointEight) {
  double squares[3] = {0, 0, 0};
  const double voxels[3] = {0.2, 0.1, 0.05};
  for (int i = 0; i < 3; ++i) {
    const std::vector<Pose> poses = BlockPoses(voxels[i]);
    for (const Pose& X_WB : poses) {
      Simulation simulation = MakeSlotSimulation(X_WB, voxels[i]);
      const double error = CutSlot(simulation, X_WB) / SlotVolume() - 1;
      squares[i] += error * error / static_cast<double>(poses.size());
    }
    std::printf("voxel %.2f mm: rms volume error %.4f %%\n", voxels[i], 100 * std::sqrt(squares[i]));
  }
  EXPECT_GE(0.5 * std::log2(squares[0] / squares[1]), 1.8);
  EXPECT_GE(0.5 * std::log2(squares[1] / squares[2]), 1.8);
}

TEST(RemovalClosedForm, KerfWidthIsWithinAHundredthOfAMillimetre) {
  for (const Pose& X_WB : BlockPoses(0.1)) {
    Simulation simulation = MakeSlotSimulation(X_WB, 0.1);
    CutSlot(simulation, X_WB);
    const Bone& bone = simulation.UpdateBone();
    // The width is measured at many places away from the kerf's floor and mouth, by bisection from the middle to each
    // wall.
    for (double x = -2.5; x <= 2.5; x += 0.37) {
      for (double z = kTop - kDepth + 0.3; z <= kTop - 0.3; z += 0.29) {
        double width = 0;
        for (int side = -1; side <= 1; side += 2) {
          double air = 0;
          double wall = 0.25;
          ASSERT_GT(bone.SignedDistance(X_WB.Point({x, 0, z})), 0);
          ASSERT_LT(bone.SignedDistance(X_WB.Point({x, side * wall, z})), 0);
          for (int i = 0; i < 30; ++i) {
            const double middle = 0.5 * (air + wall);
            (bone.SignedDistance(X_WB.Point({x, side * middle, z})) > 0 ? air : wall) = middle;
          }
          width += air;
        }
        EXPECT_NEAR(width, kSaw.thickness_mm, 0.01);
      }
    }
  }
}

TEST(RemovalClosedForm, RemovedPlusRemainingIsInitial) {
  for (const double voxel : {0.2, 0.1}) {
    for (const Pose& X_WB : BlockPoses(voxel)) {
      Simulation simulation = MakeSlotSimulation(X_WB, voxel);
      const double initial = simulation.UpdateBone().CalcVolume();
      const double removed = CutSlot(simulation, X_WB);
      // The same cells are summed in a different order, so only rounding differs.
      EXPECT_NEAR(removed + simulation.UpdateBone().CalcVolume(), initial, 1e-9 * initial);
    }
  }
}

TEST(RemovalClosedForm, CuttingTheSamePathTwiceRemovesNothingMore) {
  for (const Pose& X_WB : BlockPoses(0.2)) {
    Simulation first = MakeSlotSimulation(X_WB, 0.2);
    EXPECT_GT(CutSlot(first, X_WB), 0);
    const std::uint64_t hash = first.UpdateBone().CalcHash();
    Simulation second(std::move(first).TakeBone(), {}, DiscPose(X_WB, {-11.5, 0, CentreHeight(kDepth)}));
    EXPECT_EQ(CutSlot(second, X_WB), 0);
    EXPECT_EQ(second.UpdateBone().CalcHash(), hash);
  }
}

TEST(RemovalClosedForm, OrderOfTwoCutsDoesNotMatter) {
  for (const Pose& X_WB : BlockPoses(0.2)) {
    // A kerf along x and one that crosses it at 20 degrees, both through the middle.
    Pose X_tilted = X_WB;
    X_tilted.R_AB = X_WB.R_AB * glm::angleAxis(0.35, glm::normalize(Vec3(0.2, 0.1, 1)));
    const auto cut = [](Bone bone, const Pose& X) {
      Simulation simulation(std::move(bone), {}, DiscPose(X, {-11.5, 0, CentreHeight(kDepth)}));
      CutSlot(simulation, X);
      return std::move(simulation).TakeBone();
    };
    const Bone ab = cut(cut(Block(X_WB, 0.2), X_WB), X_tilted);
    const Bone ba = cut(cut(Block(X_WB, 0.2), X_tilted), X_WB);
    EXPECT_EQ(ab.CalcHash(), ba.CalcHash());
  }
}

TEST(RemovalClosedForm, FastPathEqualsEveryVoxelCarvedByEveryStep) {
  // Compared with brute force: the same sweeps are applied to every voxel of the grid by the definition of the rule.
  const Pose X_WB = BlockPoses(0.2)[5];
  const Bone initial = test::MakeBox(X_WB, {4, 2, 3}, 0.2);
  Pose X_a = DiscPose(X_WB, {-3, 0, 11});
  Simulation simulation(initial, {}, X_a);
  std::vector<Pose> poses;
  for (int i = 1; i <= 60; ++i) {
    // Forwards and down with a slowly turning and sliding disc: at most half a voxel per step, and a tilt well below
    // the limit of the substep rule.
    Pose X = DiscPose(X_WB, {-3 + 0.08 * i, 0.0005 * i, 11 - 0.02 * i});
    X.R_AB = glm::normalize(X.R_AB * glm::angleAxis(1e-5 * i, Vec3(1, 0, 0)));
    poses.push_back(X);
  }
  double removed = 0;
  for (const Pose& X : poses) removed += simulation.Tick({X, 0.001, 7500}).removed_mm3;
  ASSERT_GT(removed, 0.5);
  const Bone& bone = simulation.UpdateBone();
  double worst = 0;
  for (double x = -4; x <= 4; x += 0.2) {
    for (double y = -4; y <= 4; y += 0.2) {
      for (double z = -4; z <= 4; z += 0.2) {
        const Vec3 p_W = 0.2 * glm::round(Vec3(x, y, z) / 0.2);
        double phi = initial.SignedDistance(p_W);
        const bool bone_here = phi < initial.band_mm();
        Pose X_from = X_a;
        for (const Pose& X : poses) {
          // Independent of the cutter's formula: distance to a flat cylinder at 20 places along the step.
          for (int k = 0; k <= 20; ++k) {
            const Vec3 shift = X.InverseVector(X_from.p_AB - X.p_AB) * (k / 20.0);
            const Vec3 p_T = X.InversePoint(p_W) - Vec3(shift.x, shift.y, 0);
            const double radial = std::hypot(p_T.x, p_T.y) - kSaw.radius_mm();
            const double axial = std::abs(p_T.z) - 0.5 * kSaw.thickness_mm;
            const double distance = std::max(radial, axial) <= 0
                                        ? std::max(radial, axial)
                                        : std::hypot(std::max(radial, 0.0), std::max(axial, 0.0));
            phi = std::max(phi, -distance);
          }
          X_from = X;
        }
        if (!bone_here) continue;
        phi = std::clamp(phi, -initial.band_mm(), initial.band_mm());
        worst = std::max(worst, std::abs(phi - bone.SignedDistance(p_W)));
      }
    }
  }
  // The fast path may ignore motion along the spindle of up to kFlankTolerance of a voxel; the rest is rounding.
  EXPECT_LE(worst, 0.01 * 0.2 + 1e-5);
}

TEST(RemovalClosedForm, JumpDoesNotTunnel) {
  // The disc moves sideways through the block in one tick: the slab that it sweeps is removed.
  const Bone block = test::MakeBox(Pose{}, {4, 6, 3}, 0.2);
  Simulation simulation(block, {}, DiscPose(Pose{}, {0, -4, 11}));
  const TickOutput out = simulation.Tick({DiscPose(Pose{}, {0, 4, 11}), 0.001, 7500});
  // All bone above the lowest line of the rim across the full width: z > 11 - sqrt(121 - x^2), over |x| < 2.
  const double top_area = 4 * 1.5;
  const double below = 11 * 4 - (2 * std::sqrt(121 - 4.0) + 121 * std::asin(2.0 / 11));
  EXPECT_NEAR(Removed(simulation), 6 * (top_area - below), 0.01 * 36);
  EXPECT_EQ(out.status, kTickOk);
}

TEST(RemovalClosedForm, ATickUsesNoHeap) {
  for (const Pose& X_WB : {BlockPoses(0.1)[0], BlockPoses(0.1)[5]}) {
    Simulation simulation = MakeSlotSimulation(X_WB, 0.1);
    const double z = CentreHeight(kDepth);
    double removed = 0;
    const HeapUseCounter heap_uses;
    for (int i = 1; i <= 1000; ++i) {
      const Pose X_WT = DiscPose(X_WB, {-11.5 + 0.01 * i, 0, z});
      const HeapGuard guard;
      removed += simulation.Tick({X_WT, 0.001, 7500}).removed_mm3;
    }
    EXPECT_EQ(heap_uses.count(), 0);
    EXPECT_GT(removed, 1);
  }
}

TEST(RemovalClosedForm, CutThroughLeavesTwoPiecesThatSumToTheRest) {
  const Pose X_WB = BlockPoses(0.1)[6];
  const Bone block = test::MakeBox(X_WB, {4, 3, 4}, 0.1);
  Simulation simulation(block, {}, DiscPose(X_WB, {-14, 0, 8}));
  Stroke(simulation, X_WB, {-14, 0, 8}, {14, 0, 8}, 200);
  const Pieces split = SplitPieces(simulation.UpdateBone(), 0.5);
  ASSERT_EQ(split.pieces.size(), 2u);
  const double sum = split.pieces[0].CalcVolume() + split.pieces[1].CalcVolume();
  EXPECT_NEAR(sum + split.dust_mm3, simulation.UpdateBone().CalcVolume(), 1e-6 * sum);
  EXPECT_NEAR(split.pieces[0].CalcVolume() / split.pieces[1].CalcVolume(), 1, 0.01);
}

}  // namespace
}  // namespace kerf
