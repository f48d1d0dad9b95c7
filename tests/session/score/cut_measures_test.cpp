// Tests of the measures on known cuts at known positions, in any orientation relative to the lattice.
#include "session/score/cut_measures.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "bone/grid/build.h"
#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "exact_cut.h"
#include "kerf/simulation.h"
#include "session/marks/jaw.h"
#include "session/score/fit_plane.h"
#include "session/score/motion.h"
#include "session/score/plane_error.h"

namespace kerf {
namespace {

constexpr double kDegree = 0.017453292519943295;
// Tolerances of the measures.
constexpr double kOffset_mm = 0.2;
constexpr double kAngle_deg = 0.4;

Quat RandomTurn(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return glm::normalize(Quat(normal(random), normal(random), normal(random), normal(random)));
}

DiscSaw Saw() {
  DiscSaw saw;
  saw.diameter_mm = 12;
  saw.thickness_mm = 0.5;
  return saw;
}

/// A block of 16 x 10 x 8 mm at any pose, with a line of 6 mm on its top face along its x axis.
struct Case {
  BlockParams block;
  WantedCut wanted;
};

Case RandomCase(std::mt19937& random, double depth_mm, const Tool& tool = Saw()) {
  std::uniform_real_distribution<double> any(-1, 1);
  Case c;
  c.block.size_mm = {16, 10, 8};
  c.block.voxel_mm = 0.25;
  // One case in four is aligned with the lattice.
  const Quat turn = random() % 4 == 0 ? Quat(1, 0, 0, 0) : RandomTurn(random);
  c.block.X_WB = {turn, Vec3(any(random), any(random), any(random))};
  SceneExercise exercise;
  exercise.start_mm = c.block.X_WB.Point({-3, 0, 0});
  exercise.end_mm = c.block.X_WB.Point({3, 0, 0});
  exercise.into = c.block.X_WB.Vector({0, 0, -1});
  exercise.depth_mm = depth_mm;
  c.wanted = MakeWantedCut(exercise, tool);
  return c;
}

/// Returns the cut moved sideways by `offset_mm` at the middle of the wanted cut's bone, rolled about the line and
/// yawed about the direction into the bone.
WantedCut Misplace(const WantedCut& wanted, double offset_mm, double roll_deg, double yaw_deg, double deeper_mm) {
  WantedCut cut = wanted;
  const Quat roll = glm::angleAxis(-roll_deg * kDegree, wanted.along_W);
  const Quat yaw = glm::angleAxis(yaw_deg * kDegree, wanted.into_W);
  const Quat turn = yaw * roll;
  const Vec3 about_W = wanted.ToWorld({0.5 * wanted.length_mm, 0.5 * wanted.depth_mm, 0});
  cut.start_W = about_W + turn * (wanted.start_W - about_W) + offset_mm * wanted.across_W;
  cut.along_W = turn * wanted.along_W;
  cut.into_W = turn * wanted.into_W;
  cut.across_W = turn * wanted.across_W;
  cut.depth_mm += deeper_mm;
  return cut;
}

ScoreSheet Measure(const Bone& before, const Bone& after, const WantedCut& wanted,
                   ExerciseKind kind = ExerciseKind::kGroove) {
  ScoreSheet sheet = MakeSheet(kind);
  MeasureCut(before, after, {wanted}, {}, sheet);
  return sheet;
}

TEST(MeasureCut, PerfectCutHasNoErrorInAnyOrientation) {
  std::mt19937 random(11);
  for (int i = 0; i < 20; ++i) {
    const Case c = RandomCase(random, 3);
    const ScoreSheet sheet =
        Measure(MakeBlock(c.block, DefaultMandibleTable()), test::CutExactly(c.block, {c.wanted}), c.wanted);
    EXPECT_NEAR(sheet.Get("plane_offset_mm").value(), 0, kOffset_mm);
    EXPECT_LT(sheet.Get("plane_angle_deg").value(), kAngle_deg);
    EXPECT_LT(sheet.Get("depth_error_worst_mm").value(), kOffset_mm);
    EXPECT_LT(sheet.Get("too_deep_mm").value(), kOffset_mm);
    EXPECT_GT(sheet.Get("cut_share").value(), 0.97);
    EXPECT_NEAR(sheet.Get("outside_mm3").value(), 0, 1e-3);  // rounding of floats, summed over cells
    // The area is measured in squares of 0.375 mm, so some hundredths of it, along its border, are uncertain.
    EXPECT_NEAR(sheet.Get("kerf_width_mm").value(), 0.5, 0.05);
    EXPECT_GT(sheet.Get("dice").value(), 0.95);
  }
}

TEST(MeasureCut, MisplacedCutsAreMeasuredToAFifthOfAMillimetreAndFourTenthsOfADegree) {
  std::mt19937 random(12);
  std::uniform_real_distribution<double> any(-1, 1);
  for (int i = 0; i < 24; ++i) {
    const Case c = RandomCase(random, i % 2 == 0 ? 4 : 2);
    const double offset_mm = 2 * any(random);
    const double roll_deg = 8 * any(random);
    const double yaw_deg = 8 * any(random);
    const WantedCut made = Misplace(c.wanted, offset_mm, roll_deg, yaw_deg, 0);
    const ScoreSheet sheet =
        Measure(MakeBlock(c.block, DefaultMandibleTable()), test::CutExactly(c.block, {made}), c.wanted);
    const PlaneError truth = CalcPlaneError(made.plane(), c.wanted, c.wanted.ToWorld({3, 0.5 * c.wanted.depth_mm, 0}));
    // The middle of the bone in the wanted cut differs slightly from the point of rotation.
    EXPECT_NEAR(sheet.Get("plane_offset_mm").value(), offset_mm, kOffset_mm);
    EXPECT_NEAR(sheet.Get("plane_roll_deg").value(), truth.roll_deg, kAngle_deg);
    EXPECT_NEAR(sheet.Get("plane_yaw_deg").value(), truth.yaw_deg, kAngle_deg);
    EXPECT_NEAR(sheet.Get("plane_angle_deg").value(), truth.angle_deg, kAngle_deg);
    EXPECT_NEAR(truth.roll_deg, roll_deg, 0.2);  // the rotations are successive, hence the cosine of 8 degrees
    EXPECT_NEAR(std::abs(truth.yaw_deg), std::abs(yaw_deg), 0.2);
  }
}

/// Returns the motion of a tool that makes a cut along its line at full depth, in 2 s. `turn_deg`: of the tool, about
/// the line through its origin.
MotionMeter MoveAlong(const WantedCut& cut, bool contact = true, double turn_deg = 0) {
  MotionMeter meter(0);
  for (int i = 0; i <= 500; ++i) {
    MotionTick tick;
    tick.time_s = 0.004 * (i + 1);
    tick.dt_s = 0.004;
    tick.contact = contact;
    tick.X_WT = cut.CalcToolPose(cut.length_mm * i / 500.0, cut.depth_mm);
    tick.X_WT.R_AB = glm::angleAxis(turn_deg / kDegreesPerRad, cut.along_W) * tick.X_WT.R_AB;
    meter.Take(tick);
  }
  return meter;
}

// A groove hardly deeper than the bur is wide: its shape does not show the lean, but the bur's axis does. The bur moves
// in the plane of an exact cut, whose angles follow from the turns that misplaced it.
TEST(MeasureCut, LeanOfABurIsThatOfItsAxis) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(-1, 1);
  const FissureBur bur{.diameter_mm = 2.1, .length_mm = 10};
  for (int i = 0; i < 8; ++i) {
    SCOPED_TRACE(i);
    const Case c = RandomCase(random, 3, bur);
    const Bone before = MakeBlock(c.block, DefaultMandibleTable());
    const WantedCut made = Misplace(c.wanted, 0.5 * any(random), 12 * any(random), 6 * any(random), 0);
    const PlaneError truth = CalcPlaneError(made.plane(), c.wanted, c.wanted.ToWorld({3, 1.5, 0}));
    const Bone after = test::CutExactly(c.block, {made});
    const DepthGauge gauge(before, c.wanted);
    const auto leans_deg = MoveAlong(made).FindLeans_deg({&gauge, 1});
    ASSERT_EQ(leans_deg.size(), 1u);
    EXPECT_NEAR(leans_deg[0].value(), truth.roll_deg, kAngle_deg);
    ScoreSheet sheet = MakeSheet(ExerciseKind::kGroove);
    MeasureCut(before, after, {c.wanted}, leans_deg, sheet);
    EXPECT_NEAR(sheet.Get("plane_roll_deg").value(), truth.roll_deg, kAngle_deg);
    EXPECT_NEAR(sheet.Get("plane_yaw_deg").value(), truth.yaw_deg, kAngle_deg);
    EXPECT_NEAR(sheet.Get("plane_angle_deg").value(), truth.angle_deg, kAngle_deg);
    EXPECT_NEAR(sheet.Get("plane_offset_mm").value(), truth.offset_mm, kOffset_mm);
  }
}

// Half a turn about the line leads back to the wanted plane, but the bur is upside down.
TEST(MeasureCut, AnAxisThatPointsOutOfTheBoneLeansByARightAngle) {
  std::mt19937 random(11);
  const Case c = RandomCase(random, 3, FissureBur{.diameter_mm = 2.1, .length_mm = 10});
  const Bone before = MakeBlock(c.block, DefaultMandibleTable());
  const DepthGauge gauge(before, c.wanted);
  for (const double turn_deg : {95.0, 150.0, 180.0, -120.0}) {
    SCOPED_TRACE(turn_deg);
    const auto leans_deg = MoveAlong(c.wanted, true, turn_deg).FindLeans_deg({&gauge, 1});
    EXPECT_EQ(std::abs(leans_deg[0].value()), 90);
    ScoreSheet sheet = MakeSheet(ExerciseKind::kGroove);
    MeasureCut(before, test::CutExactly(c.block, {c.wanted}), {c.wanted}, leans_deg, sheet);
    EXPECT_GT(sheet.Get("plane_angle_deg").value(), 88);
    EXPECT_NEAR(sheet.Get("plane_yaw_deg").value(), 0, kAngle_deg);
  }
}

TEST(MeasureCut, LeanOfABurIsUnknownIfItTouchedNothingOrWasShallow) {
  std::mt19937 random(10);
  const Case c = RandomCase(random, 3, FissureBur{.diameter_mm = 2.1, .length_mm = 10});
  const Bone before = MakeBlock(c.block, DefaultMandibleTable());
  const DepthGauge gauge(before, c.wanted);
  const WantedCut leaning = Misplace(c.wanted, 0, 8, 0, 0);
  const WantedCut shallow = Misplace(c.wanted, 0, 8, 0, -1.7);
  EXPECT_FALSE(MoveAlong(leaning, false).FindLeans_deg({&gauge, 1})[0]);
  EXPECT_FALSE(MoveAlong(shallow).FindLeans_deg({&gauge, 1})[0]);
  EXPECT_NEAR(MoveAlong(leaning).FindLeans_deg({&gauge, 1})[0].value(), 8, 1e-6);
  ScoreSheet sheet = MakeSheet(ExerciseKind::kGroove);
  MeasureCut(before, test::CutExactly(c.block, {shallow}), {c.wanted}, {}, sheet);
  EXPECT_FALSE(sheet.Get("plane_roll_deg"));
  EXPECT_NEAR(sheet.Get("plane_angle_deg").value(), 0, kAngle_deg);
  // A blade's plane shows its lean.
  const Case saw = RandomCase(random, 3);
  const DepthGauge saw_gauge(before, saw.wanted);
  EXPECT_FALSE(MoveAlong(saw.wanted).FindLeans_deg({&saw_gauge, 1})[0]);
}

TEST(MeasureCut, DepthIsMeasuredToAFifthOfAMillimetre) {
  std::mt19937 random(13);
  for (const double deeper_mm : {-1.5, -0.6, 0.4, 1.0, 2.0}) {
    const Case c = RandomCase(random, 3);
    const WantedCut made = Misplace(c.wanted, 0.3, 0, 0, deeper_mm);
    const ScoreSheet sheet =
        Measure(MakeBlock(c.block, DefaultMandibleTable()), test::CutExactly(c.block, {made}), c.wanted);
    for (const char* key : {"depth_error_mean_mm", "depth_error_p95_mm", "depth_error_worst_mm"}) {
      EXPECT_NEAR(sheet.Get(key).value(), std::abs(deeper_mm), kOffset_mm) << key;
    }
    EXPECT_NEAR(sheet.Get("too_deep_mm").value(), std::max(deeper_mm, 0.0), kOffset_mm);
    // The whole line is cut, as deep as it was made; what lies outside lies below the wanted cut.
    EXPECT_EQ(sheet.begun_share, 1);
    EXPECT_NEAR(sheet.depth_mm.value(), 3 + deeper_mm, kOffset_mm);
    if (deeper_mm < 0) {
      EXPECT_EQ(sheet.below_mm3, 0);
    }
    EXPECT_LE(sheet.below_mm3 + sheet.beyond_mm3, sheet.Get("outside_mm3").value() + 1e-9);
    if (deeper_mm > 1) {
      EXPECT_GT(sheet.below_mm3, 0.8 * sheet.Get("outside_mm3").value());
    }
  }
}

// A cut exactly made up to a part of the line is deep enough there and stops.
TEST(MeasureCut, DeepStretchEndsWhereTheCutStopped) {
  std::mt19937 random(14);
  const Case c = RandomCase(random, 3);
  WantedCut made = c.wanted;
  made.length_mm = 0.5 * c.wanted.length_mm;
  const ScoreSheet sheet =
      Measure(MakeBlock(c.block, DefaultMandibleTable()), test::CutExactly(c.block, {made}), c.wanted);
  // The rim of the disc is 0.3 mm above its lowest point at this distance from it.
  const double chord_mm = std::sqrt(0.3 * (2 * c.wanted.radius_mm - 0.3));
  ASSERT_TRUE(sheet.deep);
  EXPECT_NEAR(sheet.deep->share, 0.5 + chord_mm / c.wanted.length_mm, 1 / c.wanted.length_mm);
  EXPECT_TRUE(sheet.deep->from_start);
  EXPECT_LT(sheet.deep->shallow_mm, 0.15);
  EXPECT_FALSE(sheet.deep->goes_on);

  // If a cut that stopped soon goes on to the end of the line at two thirds of the depth, it did not stop. The arc that
  // the disc left is 0.3 mm less deep than that over the last quarter of the line.
  made.length_mm = 0.15 * c.wanted.length_mm;
  WantedCut shallow = c.wanted;
  shallow.depth_mm = 2;
  const auto measure = [&](const std::vector<WantedCut>& cuts) {
    return Measure(MakeBlock(c.block, DefaultMandibleTable()), test::CutExactly(c.block, cuts), c.wanted);
  };
  EXPECT_FALSE(measure({made}).deep->goes_on);
  const ScoreSheet on = measure({made, shallow});
  ASSERT_TRUE(on.deep);
  EXPECT_NEAR(on.deep->share, 0.15 + chord_mm / c.wanted.length_mm, 1 / c.wanted.length_mm);
  EXPECT_TRUE(on.deep->goes_on);
}

TEST(MeasureCut, VolumeOutsideTheMarginIsCounted) {
  std::mt19937 random(14);
  Case c = RandomCase(random, 3);
  c.wanted.margin_mm = 0.5;
  const Bone before = MakeBlock(c.block, DefaultMandibleTable());
  const Bone after = test::CutExactly(c.block, {Misplace(c.wanted, 3, 0, 0, 0)});
  const ScoreSheet sheet = Measure(before, after, c.wanted);
  EXPECT_NEAR(sheet.Get("removed_mm3").value(), before.CalcVolume() - after.CalcVolume(), 1e-6);
  EXPECT_NEAR(sheet.Get("outside_mm3").value(), sheet.Get("removed_mm3").value(), 1e-9);
  EXPECT_EQ(sheet.below_mm3 + sheet.beyond_mm3, 0);
  EXPECT_EQ(sheet.Get("cut_share").value(), 0);
  EXPECT_NEAR(sheet.Get("under_mm3").value(), sheet.Get("planned_mm3").value(), 1e-9);
  // The kerf lies evenly on both sides of its plane. The centre of a cell that is cut in part is up to a diagonal away.
  EXPECT_NEAR(sheet.beside_mm.value(), 3, kOffset_mm);
  EXPECT_NEAR(sheet.farthest_mm.value(), 3 + 0.5 * c.wanted.thickness_mm, 2 * before.voxel_mm());
}

TEST(MeasureCut, SimulatedCutMatchesTheExactCut) {
  std::mt19937 random(15);
  for (int i = 0; i < 2; ++i) {
    const Case c = RandomCase(random, 3);
    const Bone before = MakeBlock(c.block, DefaultMandibleTable());
    SimulationParams params;
    params.tool = Saw();
    params.effects = {};
    Pose X_WT = c.wanted.CalcToolPose(0, -1);
    Simulation simulation(before, params, X_WT);
    const auto go_to = [&](double s_mm, double t_mm, int ticks) {
      const Vec3 from = X_WT.p_AB;
      const Pose X_to = c.wanted.CalcToolPose(s_mm, t_mm);
      for (int k = 1; k <= ticks; ++k) {
        X_WT.p_AB = glm::mix(from, X_to.p_AB, static_cast<double>(k) / ticks);
        simulation.Tick({.X_WT = X_WT, .dt_s = 0.001, .rpm = 7500});
      }
    };
    go_to(0, 3, 400);
    go_to(6, 3, 600);
    go_to(6, -1, 400);
    const ScoreSheet sheet = Measure(before, std::move(simulation).TakeBone(), c.wanted);
    EXPECT_NEAR(sheet.Get("plane_offset_mm").value(), 0, kOffset_mm);
    EXPECT_LT(sheet.Get("plane_angle_deg").value(), kAngle_deg);
    EXPECT_LT(sheet.Get("depth_error_worst_mm").value(), kOffset_mm);
    EXPECT_GT(sheet.Get("cut_share").value(), 0.97);
  }
}

TEST(CutMeasures, AStrayCutBesideThePlaneDoesNotTiltIt) {
  std::mt19937 random(20);
  for (int i = 0; i < 8; ++i) {
    const Case c = RandomCase(random, 3);
    // A third as long, and 3.5 mm beside.
    SceneExercise exercise;
    exercise.start_mm = c.block.X_WB.Point({1, 3.5, 0});
    exercise.end_mm = c.block.X_WB.Point({3, 3.5, 0});
    exercise.into = c.block.X_WB.Vector({0, 0, -1});
    exercise.depth_mm = 2;
    const WantedCut stray = MakeWantedCut(exercise, Saw());
    const Bone before = test::CutExactly(c.block, {});
    const ScoreSheet sheet = Measure(before, test::CutExactly(c.block, {c.wanted, stray}), c.wanted);
    EXPECT_NEAR(sheet.Get("plane_offset_mm").value(), 0, kOffset_mm);
    EXPECT_LT(sheet.Get("plane_angle_deg").value(), kAngle_deg);
    EXPECT_GT(sheet.Get("outside_mm3").value(), 0.9 * 2 * 2 * 0.5);  // it is still counted there
    EXPECT_NEAR(sheet.Get("planned_mm3").value() - sheet.Get("under_mm3").value() + sheet.Get("margin_mm3").value() +
                    sheet.Get("outside_mm3").value(),
                sheet.Get("removed_mm3").value(), 1e-9);
    EXPECT_TRUE(sheet.injured.empty());  // the block has no teeth
  }
}

TEST(CutMeasures, ToothCutBesideTheWantedCutIsNamed) {
  const Bone before = test::MakeJaw();
  const Bone after = test::MakeJaw(5, 4);  // a slot through a tooth at x = 5
  const auto measure = [&](double x_mm, ExerciseKind kind = ExerciseKind::kGroove) {
    SceneExercise exercise;
    exercise.start_mm = {x_mm, -9, 0};
    exercise.end_mm = {x_mm, 9, 0};
    exercise.depth_mm = 5;
    return Measure(before, after, MakeWantedCut(exercise, DiscSaw{.diameter_mm = 22, .thickness_mm = 0.4}), kind);
  };
  EXPECT_TRUE(measure(5).injured.empty());  // the wanted cut goes through the tooth
  const std::vector<OutsideInjury> beside = measure(9).injured;
  ASSERT_EQ(beside.size(), 1U);
  EXPECT_EQ(beside[0].structure.kind, MarkKind::kTooth);
  EXPECT_NEAR(beside[0].away_mm, 4 - 0.2, 0.1);
  EXPECT_NEAR(beside[0].structure.removed_mm3, 0.4 * 4 * 4, 0.1 * 0.4 * 4 * 4);
  EXPECT_TRUE(measure(9).crossed.empty());
  // What a planned cut crosses is no injury.
  const ScoreSheet planned = measure(5, ExerciseKind::kOsteotomy);
  EXPECT_TRUE(planned.injured.empty());
  ASSERT_EQ(planned.crossed.size(), 1U);
  EXPECT_NEAR(planned.crossed[0].removed_mm3, beside[0].structure.removed_mm3, 1e-6);
}

TEST(FitMiddlePlane, ReturnsNoneForALumpOrNoRemoval) {
  BlockParams params;
  params.size_mm = {5, 5, 5};
  params.voxel_mm = 0.25;
  const Bone bone = MakeBlock(params, DefaultMandibleTable());
  EXPECT_FALSE(FitMidPlane(bone, bone, {}));
  std::vector<RemovedCell> lump;
  for (int i = 0; i < 1000; ++i) {
    lump.push_back(
        {.p_W = {0.1 * (i % 10), 0.1 * (i / 10 % 10), 0.1 * (i / 100)}, .mm3 = 0.001, .region = 1, .in_mm = 9});
  }
  EXPECT_FALSE(FitMidPlane(bone, bone, lump));
}

TEST(DepthGauge, MeasuresToSurfaceFarSideAndGoal) {
  std::mt19937 random(16);
  const Case c = RandomCase(random, 3);
  const DepthGauge gauge(MakeBlock(c.block, DefaultMandibleTable()), c.wanted);
  for (const double t_mm : {-2.0, 1.0, 3.0, 9.5}) {
    const std::optional<DepthReading> reading = gauge.Calc(c.wanted.CalcToolPose(2, t_mm));
    ASSERT_TRUE(reading);
    // The tolerance covers the face of the block in voxels of 0.25 mm and the spacing of the rim's 120 points.
    // The block is 8 mm thick: a cut through it is no deeper, as in the score.
    EXPECT_NEAR(reading->depth_mm, std::min(t_mm, 8.0), 0.05);
    EXPECT_NEAR(reading->to_goal_mm, 3 - std::min(t_mm, 8.0), 0.05);
    EXPECT_EQ(reading->bone_mm.has_value(), t_mm > 8);
    EXPECT_NEAR(reading->bone_mm.value_or(8), 8, 0.05);
    EXPECT_NEAR(reading->beyond_mm, t_mm - 8, 0.05);
  }
  const Bone bone = MakeBlock(c.block, DefaultMandibleTable());
  EXPECT_NEAR(CalcBladeDepth(PhiSampler(bone), Saw(), c.wanted.CalcToolPose(2, 3)), 3, 0.05);
  EXPECT_EQ(CalcBladeDepth(PhiSampler(bone), Saw(), c.wanted.CalcToolPose(2, -0.5)), 0);
}

TEST(DepthGauge, DiscThatOnlyPlungesReachesEveryColumnBelowIt) {
  std::mt19937 random(16);
  const Case c = RandomCase(random, 3);
  const DepthGauge gauge(MakeBlock(c.block, DefaultMandibleTable()), c.wanted);
  std::vector<double> deepest_mm(gauge.columns().size(), -100);
  constexpr double kPlace_mm = 2;
  constexpr double kDepth_mm = 3;
  gauge.TakeDepths(c.wanted.CalcToolPose(kPlace_mm, kDepth_mm), deepest_mm);
  const double radius_mm = c.wanted.radius_mm;
  int reached = 0;
  for (std::size_t i = 0; i < deepest_mm.size(); ++i) {
    const double s_mm = gauge.columns()[i].s_mm - kPlace_mm;
    const double depth_mm = kDepth_mm - radius_mm + std::sqrt(std::max(0.0, radius_mm * radius_mm - s_mm * s_mm));
    if (depth_mm < 1) continue;
    // A point belongs to the column that is at most half of their distance away, where the rim is that much deeper or
    // less deep; the face of the block is in voxels of 0.25 mm.
    const double slope = std::abs(s_mm) / std::sqrt(radius_mm * radius_mm - s_mm * s_mm);
    EXPECT_NEAR(deepest_mm[i], depth_mm, 0.05 + 0.13 * slope) << s_mm;
    ++reached;
  }
  EXPECT_GT(reached, 30);
}

TEST(DepthGauge, MeasuresTheTipOfABur) {
  BlockParams block;
  block.size_mm = {16, 10, 8};
  block.voxel_mm = 0.25;
  block.X_WB = {glm::angleAxis(0.4, glm::normalize(Vec3(1, 2, 3))), Vec3(0.3, 0.1, -0.2)};
  SceneExercise exercise;
  exercise.start_mm = block.X_WB.Point({-3, 0, 0});
  exercise.end_mm = block.X_WB.Point({3, 0, 0});
  exercise.into = block.X_WB.Vector({0, 0, -1});
  exercise.depth_mm = 3;
  const FissureBur bur{.diameter_mm = 2.1, .length_mm = 6, .point_angle_deg = 120};
  const WantedCut wanted = MakeWantedCut(exercise, bur);
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  const DepthGauge gauge(bone, wanted);
  for (const double t_mm : {-2.0, 1.0, 3.0}) {
    const Pose X_WT = wanted.CalcToolPose(2, t_mm);
    const std::optional<DepthReading> reading = gauge.Calc(X_WT);
    ASSERT_TRUE(reading);
    EXPECT_NEAR(reading->depth_mm, t_mm, 0.05);
    EXPECT_NEAR(reading->to_goal_mm, 3 - t_mm, 0.05);
    EXPECT_NEAR(CalcBladeDepth(PhiSampler(bone), bur, X_WT), std::max(t_mm, 0.0), 0.05);
  }
}

}  // namespace
}  // namespace kerf
