// A reciprocating blade on a path: removed volume and force compared with closed forms.
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

constexpr double kHalfTurn = std::numbers::pi;
const Vec3 kSawnSize(6, 3, 5);        // mm; the top face is at z = 2.5 in the block's frame
constexpr double kSlotDepth = 2.013;  // as the kerf of the blade no multiple of a voxel

/// Blade whose ends stay outside of the block at all times.
ReciprocatingBlade LongBlade() {
  ReciprocatingBlade blade;
  blade.length_mm = 12;
  blade.thickness_mm = 0.417;
  return blade;
}

/// Pose of the blade in the block's frame: middle of the edge p_B, edge along the block's x, feed along -z, blade in
/// the plane y = 0.
Pose BladePose(const Pose& X_WB, const Vec3& p_B) {
  // Columns of R_BT: x_T = -z_B, y_T = x_B, z_T = -y_B.
  return {X_WB.R_AB * CalcEdgeDown(), X_WB.Point(p_B)};
}

std::vector<TickOutput> FeedBlade(Simulation& simulation, const Pose& X_WB, double from_z, double to_z, int ticks,
                                  double dt_s, double rpm) {
  std::vector<TickOutput> out;
  for (int i = 1; i <= ticks; ++i) {
    out.push_back(simulation.Tick({BladePose(X_WB, {0, 0, from_z + (to_z - from_z) * i / ticks}), dt_s, rpm}));
  }
  return out;
}

SimulationParams BladeParams(const ReciprocatingBlade& blade, const char* law = "") {
  SimulationParams params;
  params.tool = blade;
  if (*law != '\0') params.law = ForceLaw(law);
  return params;
}

/// Returns the volume of a slot of kSlotDepth through the whole block, relative to the exact one, less 1.
double CalcSlotError(const Pose& X_WB, double voxel_mm) {
  const ReciprocatingBlade blade = LongBlade();
  Simulation simulation(test::MakeBox(X_WB, kSawnSize, voxel_mm), BladeParams(blade), BladePose(X_WB, {0, 0, 3}));
  FeedBlade(simulation, X_WB, 3, 2.5 - kSlotDepth, 100, 1e-3, 15000);
  const std::array<double, 256> mm3 = simulation.CalcRemovedByRegion();
  return std::accumulate(mm3.begin(), mm3.end(), 0.0) / (blade.kerf_mm() * kSlotDepth * kSawnSize.x) - 1;
}

TEST(Reciprocating, SlotVolumeIsWithinOnePercentInEveryPose) {
  for (const Pose& X_WB : BlockPoses(0.1)) EXPECT_NEAR(CalcSlotError(X_WB, 0.1), 0, 0.01);
}

TEST(Reciprocating, SlotVolumeConvergesWithOrderAtLeastOnePointEight) {
  double squares[3] = {0, 0, 0};
  const double voxels[3] = {0.2, 0.1, 0.05};
  for (int i = 0; i < 3; ++i) {
    // Poses oblique to the grid. Walls parallel to its layers have errors that depend on where they lie between them.
    const std::vector<Pose> all = BlockPoses(voxels[i]);
    const std::vector<Pose> poses(all.begin() + 3, all.end());
    for (const Pose& X_WB : poses) {
      const double error = CalcSlotError(X_WB, voxels[i]);
      squares[i] += error * error / static_cast<double>(poses.size());
    }
    std::printf("voxel %.2f mm: rms volume error %.4f %%\n", voxels[i], 100 * std::sqrt(squares[i]));
  }
  EXPECT_GE(0.5 * std::log2(squares[0] / squares[1]), 1.8);
  EXPECT_GE(0.5 * std::log2(squares[1] / squares[2]), 1.8);
}

TEST(Reciprocating, PlungedBladeLeavesItsOutlineAndTheWayOfItsStroke) {
  // The tip is inside the block: the slot ends half a stroke beyond it.
  ReciprocatingBlade blade;
  blade.length_mm = 10;
  blade.stroke_mm = 2;
  const Pose X_WB = BlockPoses(0.1)[5];
  Simulation simulation(test::MakeBox(X_WB, {12, 3, 5}, 0.1), BladeParams(blade), BladePose(X_WB, {-4, 0, 3}));
  for (int i = 1; i <= 100; ++i) {
    simulation.Tick({BladePose(X_WB, {-4, 0, 3 - (0.5 + kSlotDepth) * i / 100}), 1e-3, 15000});
  }
  // At rest at the floor the blade reaches both ends of its stroke.
  for (int i = 0; i < 8; ++i) simulation.Tick({BladePose(X_WB, {-4, 0, 2.5 - kSlotDepth}), 1e-3, 15000});
  const std::array<double, 256> mm3 = simulation.CalcRemovedByRegion();
  const double length_mm = -4 + 5 + 1 - (-6);
  EXPECT_NEAR(std::accumulate(mm3.begin(), mm3.end(), 0.0) / (blade.kerf_mm() * kSlotDepth * length_mm), 1, 0.015);
}

Bone SawnBlock(const Pose& X_WB) {
  Bone bone = test::MakeBox(X_WB, kSawnSize, 0.1);
  bone.set_materials(test::OneRegionTable(24, 19300, 0.28));
  return bone;
}

TEST(Reciprocating, ForceIsThatOfTheLawAtTheBiteOfEachMoment) {
  // All of the block's length is engaged. The force of a tick is the sum over the teeth of the law at the mean bite of
  // the tick, and its sum over a period is the integral of the law over the phase.
  const ReciprocatingBlade blade = LongBlade();
  const ToothForce law = MakeToothForce(ForceLaw("edge_plus_chip"), blade);
  constexpr double kBladeFeed = 2, kStrokesPerMin = 1200;  // 20 strokes a second, 50 ms
  const ToothCut bone = Cortical(CalcReducedModulus(blade.E_MPa, blade.nu, 19300, 0.28));
  const double teeth = kSawnSize.x / blade.pitch_mm;
  const Drive drive(blade);
  const double rad_per_s = 2 * kHalfTurn * kStrokesPerMin / 60;
  for (const Pose& X_WB : BlockPoses(0.1)) {
    Simulation simulation(SawnBlock(X_WB), BladeParams(blade, "edge_plus_chip"), BladePose(X_WB, {0, 0, 2.6}));
    FeedBlade(simulation, X_WB, 2.6, 2.3, 150, 1e-3, kStrokesPerMin);  // ends after three periods, at phase 0
    const std::vector<TickOutput> ticks = FeedBlade(simulation, X_WB, 2.3, 2.2, 50, 1e-3, kStrokesPerMin);
    double sum_N = 0, moment_Nmm = 0;
    for (std::size_t i = 0; i < ticks.size(); ++i) {
      const double phase = rad_per_s * 1e-3 * static_cast<double>(i);
      const double since_s = drive.CalcMeanSincePassed(phase, rad_per_s * 1e-3) / rad_per_s;
      EXPECT_NEAR(ticks[i].engaged_teeth / teeth, 1, 1e-4);  // 1e-5: distances are floats
      EXPECT_NEAR(ticks[i].mean_bite_mm, kBladeFeed * since_s, 1e-9 + 1e-6 * kBladeFeed * since_s);
      EXPECT_NEAR(ticks[i].thrust_sum_N, ticks[i].engaged_teeth * law(kBladeFeed * since_s, bone),
                  1e-6 + 1e-6 * ticks[i].thrust_sum_N);
      // Against the feed, which is the block's -z.
      EXPECT_NEAR(glm::dot(ticks[i].f_T_W_N, X_WB.Vector({0, 0, 1})), ticks[i].thrust_sum_N, 1e-9);
      sum_N += ticks[i].thrust_sum_N / 50;
      moment_Nmm = std::max(
          moment_Nmm, std::abs(glm::dot(ticks[i].tau_TG_W_Nmm, X_WB.Vector({0, -1, 0})) / ticks[i].thrust_sum_N - 100));
    }
    double integral_N = 0;
    constexpr int kParts = 2000;
    for (int i = 0; i < kParts; ++i) {
      const double since_s = drive.CalcMeanSincePassed(2 * kHalfTurn * i / kParts, 2 * kHalfTurn / kParts) / rad_per_s;
      integral_N += teeth * law(kBladeFeed * since_s, bone) / kParts;
    }
    EXPECT_NEAR(sum_N / integral_N, 1, 0.03);
    // The block stays where it is while the blade moves: the lever from the grip is 100 mm at all phases.
    EXPECT_LT(moment_Nmm, 0.5);
  }
}

TEST(Reciprocating, WorkIsExactAtFewTicksAPeriodForALawLinearInTheBite) {
  // Work of a tooth over half a period: F0 stroke + dF/dbite pitch feed half a period.
  const ReciprocatingBlade blade = LongBlade();
  SimulationParams params = BladeParams(blade, "two_component");
  params.law.Set("crossover_share", 0);
  const ToothForce law = MakeToothForce(params.law, blade);
  const ToothCut bone = Cortical(CalcReducedModulus(blade.E_MPa, blade.nu, 19300, 0.28));
  constexpr double kFeedSpeed = 5, kPeriod_s = 0.004;
  const auto work_mJ = [&](double (*force)(const ToothForce&, double, const ToothCut&)) {
    const double at_0 = force(law, 0, bone);
    return 2 * at_0 * blade.stroke_mm +
           (force(law, 0.01, bone) - at_0) / 0.01 * blade.pitch_mm * kFeedSpeed * kPeriod_s;
  };
  const Pose X_WB = BlockPoses(0.1)[4];
  for (const int ticks : {1, 3, 4, 16}) {
    Simulation simulation(SawnBlock(X_WB), params, BladePose(X_WB, {0, 0, 2.6}));
    const double rate = 60 / kPeriod_s;
    FeedBlade(simulation, X_WB, 2.6, 2.3, 15 * ticks, kPeriod_s / ticks, rate);
    double cutting_mJ = 0, thrust_mJ = 0;
    for (const TickOutput& out : FeedBlade(simulation, X_WB, 2.3, 2.2, 5 * ticks, kPeriod_s / ticks, rate)) {
      cutting_mJ += 1e3 * out.cutting_W * kPeriod_s / ticks / out.engaged_teeth;
      thrust_mJ += 1e3 * out.thrust_W * kPeriod_s / ticks / out.engaged_teeth;
    }
    // Below 1e-6 by the rule that integrates the bite over the time.
    EXPECT_NEAR(cutting_mJ / (5 * work_mJ(law.cutting)), 1, 2e-6) << ticks;
    EXPECT_NEAR(thrust_mJ / (5 * work_mJ(law.thrust)), 1, 2e-6) << ticks;
  }
}

TEST(Reciprocating, MeanThrustIsTheIntegralOfTheLawAtAnyTicksAPeriod) {
  // Bites from 0 to 5 um, across the kink of two_component at 2 um, and the power 1.5 of hertz_chip.
  const ReciprocatingBlade blade = LongBlade();
  const double E_star_MPa = CalcReducedModulus(blade.E_MPa, blade.nu, 19300, 0.28);
  constexpr double kFeedSpeed = 2.4, kPeriod_s = 0.004, kHalfStroke = 1.5;
  const Pose X_WB = BlockPoses(0.1)[4];
  for (const char* name : {"two_component", "hertz_chip"}) {
    const auto law = [&](double bite_mm) {
      return *name == 't' ? blade.thickness_mm * (9.66 * std::min(1.0, bite_mm / 0.002) + 468 * bite_mm)
                          : 4.0 / 3 * E_star_MPa * std::sqrt(0.5 * blade.length_mm) * std::pow(bite_mm, 1.5);
    };
    // A tooth at the phase psi since a turn meets what it left itself before the turn or, from a pitch on, what the
    // tooth in front left after it.
    double integral_N = 0;
    constexpr int kPhases = 20000;
    for (int i = 0; i < kPhases; ++i) {
      const double psi = kHalfTurn * (i + 0.5) / kPhases;
      const double in_front = std::cos(psi) + blade.pitch_mm / kHalfStroke;
      const double since_rad = in_front > 1 ? 2 * psi : psi - std::acos(in_front);
      integral_N += law(kFeedSpeed * since_rad * kPeriod_s / (2 * kHalfTurn)) / kPhases;
    }
    for (const int ticks : {1, 3, 4, 5, 16}) {
      Simulation simulation(SawnBlock(X_WB), BladeParams(blade, name), BladePose(X_WB, {0, 0, 2.6}));
      const double rate = 60 / kPeriod_s;
      FeedBlade(simulation, X_WB, 2.6, 2.6 - 30 * kPeriod_s * kFeedSpeed, 30 * ticks, kPeriod_s / ticks, rate);
      double thrust_N = 0;
      for (const TickOutput& out : FeedBlade(simulation, X_WB, 2.6 - 30 * kPeriod_s * kFeedSpeed,
                                             2.6 - 35 * kPeriod_s * kFeedSpeed, 5 * ticks, kPeriod_s / ticks, rate)) {
        thrust_N += out.thrust_sum_N / out.engaged_teeth / (5 * ticks);
      }
      // 32 parts a period leave less than 0.5 % (docs/physics.md).
      EXPECT_NEAR(thrust_N / integral_N, 1, 0.006) << name << " " << ticks;
    }
  }
}

TEST(Reciprocating, AStoppedStrokeCutsNothingAndKeepsItsPhase) {
  const Pose X_WB;
  Simulation simulation(SawnBlock(X_WB), BladeParams(LongBlade()), BladePose(X_WB, {0, 0, 2.6}));
  const TickOutput out = simulation.Tick({BladePose(X_WB, {0, 0, 2.4}), 1e-3, 0});
  EXPECT_EQ(out.removed_mm3, 0);
  EXPECT_EQ(out.status, kTickSpindleStopped);
}

}  // namespace
}  // namespace kerf
