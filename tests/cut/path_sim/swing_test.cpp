// An oscillating blade and a piezo insert on a path: removed volume and force compared with closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numeric>

#include "cut/tool/drive.h"
#include "cut/tool/edge_down.h"
#include "kerf/simulation.h"
#include "support/cuts.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

using test::BlockPoses;

const Vec3 kSwungSize(12, 3, 5);  // mm; the top face is at z = 2.5 in the block's frame
const Vec3 kArcSize(6, 3, 5);
constexpr double kSwungDepth = 2.013;
constexpr double kSwings = 13700;  // a minute: no whole number of ticks to a period

/// Pose in the block's frame: middle of the teeth p_B, edge along the block's x, feed along -z, blade in the plane y =
/// 0.
Pose SwungPose(const Pose& X_WB, const Vec3& p_B) {
  // Columns of R_BT: x_T = -z_B, y_T = x_B, z_T = -y_B.
  return {X_WB.R_AB * CalcEdgeDown(), X_WB.Point(p_B)};
}

OscillatingBlade NarrowBlade() {
  OscillatingBlade blade;
  blade.radius_mm = 15;
  blade.width_mm = 5;
  blade.thickness_mm = 0.417;
  blade.swing_deg = 6;
  return blade;
}

SimulationParams SwungParams(const Tool& tool) {
  SimulationParams params;
  params.tool = tool;
  return params;
}

/// Feeds the tool in a straight line, and lets it swing where it ends. The swing within a tick is swept along its
/// chord, so the floor reaches the arc only at the chords' ends: after 50 ticks the volume of an arc slot is short by
/// 0.03 % more than after 800, with any voxels.
double CutVolume(const Pose& X_WB, const Vec3& size, double voxel_mm, const Tool& tool, const Vec3& from_B,
                 const Vec3& to_B, double rpm) {
  Simulation simulation(test::MakeBox(X_WB, size, voxel_mm), SwungParams(tool), SwungPose(X_WB, from_B));
  constexpr int kTicks = 300, kResting = 800;
  for (int i = 1; i <= kTicks + kResting; ++i) {
    const double at = std::min(1.0, static_cast<double>(i) / kTicks);
    simulation.Tick({SwungPose(X_WB, from_B + at * (to_B - from_B)), 1e-3, rpm});
  }
  const std::array<double, 256> mm3 = simulation.CalcRemovedByRegion();
  return std::accumulate(mm3.begin(), mm3.end(), 0.0);
}

/// Relative error of the volume of a slot through all of a block that is narrower than the arc.
double CalcArcSlotError(const Pose& X_WB, double voxel_mm) {
  OscillatingBlade blade = NarrowBlade();
  blade.width_mm = 9;
  const double R = blade.radius_mm, Y = 0.5 * kArcSize.x;
  const double area_mm2 = 2 * Y * (kSwungDepth - R) + Y * std::sqrt(R * R - Y * Y) + R * R * std::asin(Y / R);
  // So slowly that the ends of the chords come to all places.
  return CutVolume(X_WB, kArcSize, voxel_mm, blade, {0, 0, 2.6}, {0, 0, 2.5 - kSwungDepth}, 1370) /
             (blade.kerf_mm() * area_mm2) -
         1;
}

/// Relative error of the volume of a plunge: between the ends of the teeth at both ends of the swing, above the arc.
double CalcPlungeError(const Pose& X_WB, double voxel_mm) {
  const OscillatingBlade blade = NarrowBlade();
  const double R = blade.radius_mm;
  const double half_rad = 0.5 * (blade.edge_mm() + blade.stroke_mm()) / R;
  const double Y = R * std::sin(half_rad);
  const double area_mm2 = 2 * Y * (kSwungDepth - R) + Y * R * std::cos(half_rad) + R * R * half_rad;
  return CutVolume(X_WB, kSwungSize, voxel_mm, blade, {0, 0, 2.6}, {0, 0, 2.5 - kSwungDepth}, kSwings) /
             (blade.kerf_mm() * area_mm2) -
         1;
}

TEST(Oscillating, PlungeVolumeIsWithinOnePercentInEveryPose) {
  for (const Pose& X_WB : BlockPoses(0.1)) EXPECT_NEAR(CalcPlungeError(X_WB, 0.1), 0, 0.01);
}

TEST(Oscillating, SlotVolumeConvergesWithOrderAtLeastOnePointEight) {
  for (const Pose& X_WB : BlockPoses(0.1)) EXPECT_NEAR(CalcArcSlotError(X_WB, 0.1), 0, 0.01);
  double squares[3] = {0, 0, 0};
  const double voxels[3] = {0.2, 0.1, 0.05};
  for (int i = 0; i < 3; ++i) {
    const std::vector<Pose> all = BlockPoses(voxels[i]);
    const std::vector<Pose> poses(all.begin() + 3, all.end());  // oblique to the grid
    for (const Pose& X_WB : poses) {
      const double error = CalcArcSlotError(X_WB, voxels[i]);
      squares[i] += error * error / static_cast<double>(poses.size());
    }
    std::printf("voxel %.2f mm: rms volume error %.4f %%\n", voxels[i], 100 * std::sqrt(squares[i]));
  }
  EXPECT_GE(0.5 * std::log2(squares[0] / squares[1]), 1.8);
  EXPECT_GE(0.5 * std::log2(squares[1] / squares[2]), 1.8);
}

TEST(Oscillating, SlotFedAlongTheEdgeHasAFlatFloor) {
  // The foremost point of the arc passes all of the block, whatever the swing.
  const OscillatingBlade blade = NarrowBlade();
  double squares = 0;
  for (const Pose& X_WB : BlockPoses(0.1)) {
    const double z = 2.5 - kSwungDepth;
    const double error = CutVolume(X_WB, kSwungSize, 0.1, blade, {-10, 0, z}, {7, 0, z}, kSwings) /
                             (blade.kerf_mm() * kSwungDepth * kSwungSize.x) -
                         1;
    EXPECT_NEAR(error, 0, 0.01);
    squares += error * error / 8;
  }
  std::printf("slot fed along the edge: rms volume error %.4f %%\n", 100 * std::sqrt(squares));
}

TEST(Piezo, PlungeVolumeIsWithinOnePercentInEveryPose) {
  PiezoInsert insert;
  insert.thickness_mm = 0.517;
  double squares = 0;
  for (const Pose& X_WB : BlockPoses(0.1)) {
    const double error = CutVolume(X_WB, kSwungSize, 0.1, insert, {0, 0, 2.6}, {0, 0, 2.5 - kSwungDepth}, 1.68e6) /
                             (insert.kerf_mm() * kSwungDepth * (insert.width_mm + insert.stroke_mm)) -
                         1;
    EXPECT_NEAR(error, 0, 0.01);
    squares += error * error / 8;
  }
  std::printf("piezo: rms volume error %.4f %%\n", 100 * std::sqrt(squares));
}

Bone SwungBlock(const Pose& X_WB, double along_mm) {
  Bone bone = test::MakeBox(X_WB, {along_mm, 3, 5}, 0.1);
  bone.set_materials(test::OneRegionTable(24, 19300, 0.28));
  return bone;
}

/// Mean force of a law on the teeth within `half_mm` of the middle, and its part against the feed, per tooth.
struct MeanForce {
  double thrust_N = 0, against_N = 0;
};
MeanForce CalcMeanForce(const ToothForce& law, const ToothCut& bone, double half_rad, double feed_mm) {
  MeanForce mean;
  constexpr int kParts = 400;
  for (int i = 0; i < kParts; ++i) {
    const double cosine = std::cos(half_rad * (2 * (i + 0.5) / kParts - 1));
    const double force_N = law(feed_mm * cosine, bone) / kParts;
    mean.thrust_N += force_N;
    mean.against_N += force_N * cosine;
  }
  return mean;
}

TEST(Oscillating, ForceIsThatOfTheLawAtTheBiteOfEachMoment) {
  // The arc spans a block 6 mm wide, which stays where it is while the blade swings.
  OscillatingBlade blade;
  blade.width_mm = 12;
  SimulationParams params = SwungParams(blade);
  params.law = ForceLaw("edge_plus_chip");
  const ToothForce law = MakeToothForce(params.law, blade);
  const ToothCut bone = Cortical(CalcReducedModulus(blade.E_MPa, blade.nu, 19300, 0.28));
  constexpr double kSwungFeed = 2, kSlowly = 1200;  // 20 swings a second, 50 ms
  const double half_rad = std::asin(3 / blade.radius_mm);
  const double teeth = 2 * half_rad * blade.radius_mm / blade.pitch_mm;
  const Drive drive(blade);
  const double advance_rad = 2 * std::numbers::pi * kSlowly / 60 * 1e-3;
  for (const Pose& X_WB : BlockPoses(0.1)) {
    Simulation simulation(SwungBlock(X_WB, 6), params, SwungPose(X_WB, {0, 0, 2.6}));
    double moment_mm = 0;
    for (int i = 1; i <= 350; ++i) {
      const TickOutput out = simulation.Tick({SwungPose(X_WB, {0, 0, 2.6 - 1e-3 * kSwungFeed * i}), 1e-3, kSlowly});
      if (i <= 300) continue;
      const double since_s = drive.CalcMeanSincePassed(advance_rad * (i - 1), advance_rad) / (advance_rad / 1e-3);
      const MeanForce mean = CalcMeanForce(law, bone, half_rad, kSwungFeed * since_s);
      // At each end of the block the grid rounds off its corner, by less than a voxel.
      EXPECT_NEAR(out.engaged_teeth / teeth, 1, 0.03) << i;
      EXPECT_NEAR(out.thrust_sum_N, out.engaged_teeth * mean.thrust_N, 1e-6 + 2e-3 * out.thrust_sum_N);
      EXPECT_NEAR(glm::dot(out.f_T_W_N, X_WB.Vector({0, 0, 1})), out.engaged_teeth * mean.against_N,
                  1e-6 + 2e-3 * out.thrust_sum_N);
      EXPECT_NEAR(glm::dot(out.f_T_W_N, X_WB.Vector({1, 0, 0})), 0, 2e-3 * out.thrust_sum_N);
      // About the grip, behind the middle of the block: no torque.
      moment_mm = std::max(moment_mm, std::abs(glm::dot(out.tau_TG_W_Nmm, X_WB.Vector({0, 1, 0}))) / out.thrust_sum_N);
    }
    EXPECT_LT(moment_mm, 0.3);
  }
}

TEST(Piezo, ForceIsThatOfTheLawAtTheMeanBite) {
  // 28 kHz: each tooth passes its place twice in a period, far more often than once in a tick.
  const PiezoInsert insert;
  SimulationParams params = SwungParams(insert);
  params.law = ForceLaw("edge_plus_chip");
  const ToothForce law = MakeToothForce(params.law, insert);
  const ToothCut bone = Cortical(CalcReducedModulus(insert.E_MPa, insert.nu, 19300, 0.28));
  constexpr double kSwungFeed = 2;
  for (const Pose& X_WB : BlockPoses(0.1)) {
    Simulation simulation(SwungBlock(X_WB, 8), params, SwungPose(X_WB, {0, 0, 2.6}));
    for (int i = 1; i <= 300; ++i) {
      const TickOutput out =
          simulation.Tick({SwungPose(X_WB, {0, 0, 2.6 - 1e-3 * kSwungFeed * i}), 1e-3, 60 * 28000.0});
      if (i <= 200) continue;
      EXPECT_NEAR(out.engaged_teeth, insert.teeth(), 1e-5 * insert.teeth());
      EXPECT_NEAR(out.mean_bite_mm, kSwungFeed / (2 * 28000), 1e-9);
      EXPECT_NEAR(out.thrust_sum_N, insert.teeth() * law(kSwungFeed / (2 * 28000), bone), 1e-5 * out.thrust_sum_N);
    }
  }
}

}  // namespace
}  // namespace kerf
