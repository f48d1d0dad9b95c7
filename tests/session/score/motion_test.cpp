// Tests of motions with known measures.
#include "session/score/motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <numbers>
#include <random>

#include "bone/material/region_table.h"
#include "bone/models/block.h"

namespace kerf {
namespace {

constexpr double kTick_s = 0.001;

/// Measures `seconds` of ticks, each of which `fill` sets.
template <typename Fill>
ScoreSheet MeasureMotion(double seconds, double limit_N, const Fill& fill) {
  MotionMeter meter(limit_N);
  const auto ticks = static_cast<int>(std::lround(seconds / kTick_s));
  for (int i = 1; i <= ticks; ++i) {
    MotionTick tick;
    tick.time_s = i * kTick_s;
    tick.dt_s = kTick_s;
    fill(tick);
    meter.Take(tick);
  }
  ScoreSheet sheet = MakeSheet({});
  meter.Finish(DiscSaw{}, {}, nullptr, {}, sheet);
  return sheet;
}

TEST(MotionMeter, UniformStraightMotionHasItsLengthAndSpeed) {
  const ScoreSheet sheet = MeasureMotion(4, 0, [](MotionTick& tick) {
    tick.X_WT.p_AB = tick.time_s * Vec3(3, 0, 4);
    tick.contact = true;
  });
  // The motion is measured in blocks of 20 ms, so half a block is missing at each end.
  EXPECT_NEAR(sheet.Get("path_length_mm").value(), 20, 0.11);
  EXPECT_NEAR(sheet.Get("feed_mean_mm_per_s").value(), 5, 0.01);
  EXPECT_NEAR(sheet.Get("feed_cv").value(), 0, 0.01);
  EXPECT_NEAR(sheet.Get("jitter_mm").value(), 0, 1e-9);
  EXPECT_NEAR(sheet.Get("time_total_s").value(), 4, 1e-9);
  EXPECT_NEAR(sheet.Get("time_active_s").value(), 4, 1e-9);
  EXPECT_EQ(sheet.Get("strokes").value(), 1);
  EXPECT_FALSE(sheet.Get("nerve_distance_mm"));
  EXPECT_FALSE(sheet.Get("force_over_s"));
}

// Reading before the first motion costs no time. The clock starts with what comes first: the motion or the spindle. A
// spindle that is stopped after some ticks, as at the start of a session in the window, does not count.
TEST(MotionMeter, ClockStartsWithTheFirstMotionOrTheSpindle) {
  const auto time = [](double moves_from_s, double turns_from_s) {
    const ScoreSheet sheet = MeasureMotion(10, 0, [&](MotionTick& tick) {
      tick.X_WT.p_AB = std::max(0.0, tick.time_s - moves_from_s) * Vec3(0, 0, -50);
      tick.turns = tick.time_s < 0.01 || tick.time_s > turns_from_s;
    });
    return sheet.Get("time_total_s").value();
  };
  // The tool moves by half a millimetre in 0.01 s.
  EXPECT_NEAR(time(4, 100), 6, 0.012);
  EXPECT_NEAR(time(4, 7), 6, 0.012);
  EXPECT_NEAR(time(7, 4), 6, 0.002);
  EXPECT_NEAR(time(0, 4), 10, 0.012);
  EXPECT_NEAR(time(100, 0), 10, 1e-9);
  EXPECT_NEAR(time(100, 100), 10, 1e-9);  // nothing happened
  const ScoreSheet turned = MeasureMotion(10, 0, [](MotionTick& tick) {
    tick.turns = false;
    tick.X_WT.R_AB = glm::angleAxis(tick.time_s < 3 ? 0.0 : 0.1, Vec3(1, 0, 0));
  });
  EXPECT_NEAR(turned.Get("time_total_s").value(), 7, 0.002);
}

TEST(MotionMeter, JitterIsTheMedianOfATremor) {
  for (const double Hz : {8.0, 10.0, 12.0}) {
    const double amplitude_mm = 0.4;
    const ScoreSheet sheet = MeasureMotion(5, 0, [&](MotionTick& tick) {
      tick.X_WT.p_AB = Vec3(2 * tick.time_s, amplitude_mm * std::sin(2 * std::numbers::pi * Hz * tick.time_s), 0);
      tick.contact = true;
    });
    // |A sin| is below A / sqrt(2) half of the time; a mean over 0.1 s leaves up to a quarter of an 8 or 12 Hz tremor.
    EXPECT_NEAR(sheet.Get("jitter_mm").value(), amplitude_mm / std::sqrt(2.0), Hz == 10.0 ? 0.02 : 0.08) << Hz;
  }
}

TEST(MotionMeter, ForcesAreThoseInContact) {
  const ScoreSheet sheet = MeasureMotion(2, 5, [](MotionTick& tick) {
    tick.contact = tick.time_s <= 1;
    tick.force_N = tick.time_s <= 0.5 ? 4 : tick.time_s <= 1 ? 8 : 0.5;
  });
  EXPECT_NEAR(sheet.Get("force_mean_N").value(), 6, 0.02);  // one tick
  EXPECT_NEAR(sheet.Get("force_rms_N").value(), std::sqrt(40.0), 0.02);
  EXPECT_EQ(sheet.Get("force_peak_N").value(), 8);
  EXPECT_NEAR(sheet.Get("force_over_s").value(), 0.5, 0.002);
}

TEST(MotionMeter, StrokesAreContactsSeparatedInTime) {
  const ScoreSheet sheet = MeasureMotion(10, 0, [](MotionTick& tick) {
    // There are three contacts of 2 s, the second with a gap of 0.1 s.
    const double t = std::fmod(tick.time_s, 3.2);
    tick.contact = tick.time_s < 9.6 && t < 2 && !(tick.time_s > 4 && tick.time_s < 4.1);
  });
  EXPECT_EQ(sheet.Get("strokes").value(), 3);
}

/// Returns the gauge of a line of 40 mm, to be cut 2 mm deep into a block.
DepthGauge MakeLineGauge(const DiscSaw& saw) {
  BlockParams block;
  block.size_mm = {60, 10, 8};
  block.voxel_mm = 0.25;
  block.layers = {{8, 24}};
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  SceneExercise exercise;
  exercise.start_mm = {-20, 0, 0};
  exercise.end_mm = {20, 0, 0};
  exercise.depth_mm = 2;
  return DepthGauge(bone, MakeWantedCut(exercise, saw));
}

/// A disc of radius R whose lowest point is at the depth d is at least d/2 deep over a length of sqrt(R d - d^2/4) to
/// both sides. The line counts as cut that far beyond the place where the disc stopped.
TEST(MotionMeter, LineAtHalfDepthReachesAheadOfTheDiscByItsChord) {
  DiscSaw saw;
  saw.diameter_mm = 24;
  const DepthGauge gauge = MakeLineGauge(saw);
  const auto line_share = [&](double stop_mm, double depth_mm) {
    MotionMeter meter(0);
    for (int i = 1; i <= 1000; ++i) {
      MotionTick tick;
      tick.time_s = 4 * i * kTick_s;
      tick.dt_s = 4 * kTick_s;
      tick.contact = true;
      tick.X_WT = gauge.cut().CalcToolPose(stop_mm * i / 1000.0, depth_mm);
      meter.Take(tick);
    }
    ScoreSheet sheet = MakeSheet({});
    meter.Finish(saw, {&gauge, 1}, nullptr, {}, sheet);
    return sheet.Get("line_share").value();
  };
  const double chord_mm = std::sqrt(12.0 * 2 - 1);  // 4.8 mm
  // Columns are 0.25 mm apart, and the rim has a point every 0.6 mm.
  const double tolerance = 0.6 / 40;
  EXPECT_NEAR(line_share(20, 2), (20 + chord_mm) / 40, tolerance);
  EXPECT_EQ(line_share(40, 2), 1);
  EXPECT_EQ(line_share(36, 2), 1);  // 4 mm before the end
  EXPECT_LT(line_share(34, 2), 1);
  EXPECT_EQ(line_share(40, 0.9), 0);  // less than half as deep
}

// A stop of 4 s in the middle of a line that is otherwise followed at 5 mm/s.
TEST(MotionMeter, FeedAlongTheLineCountsStops) {
  const DiscSaw saw;
  const DepthGauge gauge = MakeLineGauge(saw);
  double error = -1;
  const auto measure = [&](double pause_s, double depth_mm) {
    MotionMeter meter(0);
    for (int i = 1; i <= 3000; ++i) {
      MotionTick tick;
      tick.time_s = 0.004 * i;
      tick.dt_s = 0.004;
      const double s_mm = 5 * (std::min(tick.time_s, 4.0) + std::max(tick.time_s - 4 - pause_s, 0.0));
      tick.X_WT = gauge.cut().CalcToolPose(std::min(s_mm, 40.0), depth_mm);
      meter.Take(tick);
    }
    ScoreSheet sheet = MakeSheet({});
    sheet.exercise.feed_mm_per_s = 4;
    meter.Finish(saw, {&gauge, 1}, nullptr, {}, sheet);
    error = sheet.Get("feed_error").value_or(-1);
    return sheet.feed_along;
  };
  const std::optional<FeedAlong> even = measure(0, 2);
  EXPECT_NEAR(error, 0.25, 1e-6);  // 5 rather than 4 mm/s
  ASSERT_TRUE(even);
  EXPECT_NEAR(even->slowest_mm_per_s, 5, 1e-6);  // rounding
  EXPECT_NEAR(even->fastest_mm_per_s, 5, 1e-6);
  const std::optional<FeedAlong> uneven = measure(4, 2);
  ASSERT_TRUE(uneven);
  EXPECT_NEAR(uneven->slowest_mm_per_s, 0, 1e-6);
  EXPECT_NEAR(uneven->fastest_mm_per_s, 5, 1e-6);
  // Of 9.9 s, it rests for 3.5 s and is 2 s between.
  EXPECT_NEAR(uneven->mean_mm_per_s, (5.4 * 5 + 2 * 0.5 * 2.5) / 9.9, 2e-2);
  EXPECT_NEAR(uneven->rest_share, 3.5 / 9.9, 5e-3);
  // The tool moves between 4 and 36 mm for 6.4 s, of which the first mean takes 0.5 s, and is stopped for 4 s. The mean
  // falls from 5 mm/s to 0 and rises again in 0.5 s each, with a mean error of 0.425.
  EXPECT_NEAR(error, (5.4 * 0.25 + 2 * 0.5 * 0.425 + 3.5 * 1) / 9.9, 1e-3);
  EXPECT_FALSE(measure(4, 0.9));  // less than half as deep
}

/// One movement whose speed is that of a smooth reach has a SPARC of about -1.8; a pause in the middle adds to it.
TEST(MotionMeter, SmoothnessOfOneEvenMovementIsKnown) {
  const auto sparc = [](int movements) {
    const ScoreSheet sheet = MeasureMotion(2.0 * movements, 0, [](MotionTick& tick) {
      const double whole = std::floor(tick.time_s / 2);
      const double u = std::min(tick.time_s - 2 * whole, 1.0);  // moves for 1 s, rests for 1 s
      tick.X_WT.p_AB = 20 * (whole + u * u * u * (10 - 15 * u + 6 * u * u)) * Vec3(1, 0, 0);
    });
    return sheet.Get("sparc").value();
  };
  EXPECT_NEAR(sparc(1), -1.8, 0.1);
  EXPECT_LT(sparc(2), sparc(1) - 0.3);
  EXPECT_LT(sparc(4), sparc(2) - 0.3);
}

/// The tool goes through the far side of a block 8 mm high by 2 mm and by 1 mm, and by 0.04 mm in between.
TEST(MotionMeter, PlungesAreCountedAndMeasured) {
  BlockParams block;
  block.size_mm = {16, 10, 8};
  block.voxel_mm = 0.25;
  block.layers = {{6, 24}, {2, 34}};
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  SceneExercise exercise;
  exercise.start_mm = {-3, 0, 0};
  exercise.end_mm = {3, 0, 0};
  DiscSaw saw;
  saw.diameter_mm = 24;
  const WantedCut cut = MakeWantedCut(exercise, saw);
  const DepthGauge gauge(bone, cut);
  const RegionDistance nerve(bone, Tissue::kCanal);
  MotionMeter meter(0);
  for (int i = 1; i <= 6000; ++i) {
    MotionTick tick;
    tick.time_s = i * kTick_s;
    tick.dt_s = kTick_s;
    const double past_mm = i <= 2000 ? 2 : i <= 4000 ? 0.04 : 1;
    tick.X_WT = cut.CalcToolPose(0, 4 + (4 + past_mm) * std::sin(std::numbers::pi * (i % 2000) / 2000.0));
    if (i % 2000 > 900 && i % 2000 < 1100) tick.regions_cut[0] = std::uint64_t{1} << 34;
    meter.Take(tick);
  }
  ScoreSheet sheet = MakeSheet({});
  meter.Finish(saw, {&gauge, 1}, &nerve, FindRegionsOf(bone, Tissue::kCanal), sheet);
  // The gauge is accurate to a twentieth of a millimetre.
  EXPECT_NEAR(sheet.Get("plunge_max_mm").value(), 2, 0.05);
  EXPECT_NEAR(sheet.Get("plunge_mean_mm").value(), 1.5, 0.05);
  EXPECT_EQ(sheet.Get("plunges").value(), 2);
  EXPECT_EQ(sheet.Get("breaches").value(), 3);
  // The canal is the lowest 2 mm, so the deepest point in it is 1 mm from its border. The tool is within 2 mm of the
  // canal from a depth of 4 mm on.
  EXPECT_NEAR(sheet.Get("nerve_distance_mm").value(), -1, 0.25);
  EXPECT_NEAR(sheet.Get("near_miss_s").value(), 6, 0.1);
}

/// Moves the drill straight to `to_W`, at 10 mm/s. It touches bone on the way if `contact`.
void MoveDrill(const Pose& X_from, const Pose& X_to, bool contact, MotionMeter& meter, double& time_s) {
  const double length_mm = glm::distance(X_from.p_AB, X_to.p_AB);
  const auto ticks = static_cast<int>(100 * length_mm);
  for (int i = 1; i <= ticks; ++i) {
    MotionTick tick;
    tick.time_s = time_s += kTick_s;
    tick.dt_s = kTick_s;
    tick.X_WT = X_to;
    tick.X_WT.p_AB = glm::mix(X_from.p_AB, X_to.p_AB, static_cast<double>(i) / ticks);
    tick.contact = contact;
    meter.Take(tick);
  }
}

/// Two opposite holes in a block 8 mm high, of which the first goes through and the second ends at 4 mm. Then the drill
/// goes deeper in air, and deeper in contact with its axis beside the bone.
TEST(MotionMeter, DeepestPoseInAHoleIsInTheBone) {
  BlockParams block;
  block.size_mm = {30, 12, 8};
  block.voxel_mm = 0.5;
  block.layers = {{8, 24}};
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  SceneExercise exercise;
  exercise.kind = ExerciseKind::kDrillHoles;
  exercise.start_mm = {10, 0, 0};
  exercise.into = {0, 0, -1};
  exercise.depth_mm = 9;
  exercise.further.push_back({.start_mm = {13, 0, -8}, .into = {0, 0, 1}, .depth_mm = 4});
  const std::vector<WantedCut> holes = MakeWantedCuts(exercise, TwistDrill{.diameter_mm = 1.5});
  ASSERT_EQ(holes.size(), 2U);
  const auto at = [&holes](std::size_t hole, double depth_mm, double beside_mm) {
    Pose X = holes[hole].CalcToolPose(0, depth_mm);
    X.p_AB.x += beside_mm;
    return X;
  };
  MotionMeter meter(0);
  double time_s = 0;
  for (const std::size_t hole : {0U, 1U}) {
    const double depth_mm = hole == 0 ? 8 : 4;
    MoveDrill(at(hole, -3, 0), at(hole, 0, 0), false, meter, time_s);
    MoveDrill(at(hole, 0, 0), at(hole, depth_mm, 0), true, meter, time_s);
    // Beyond the far side, the drill touches nothing.
    if (hole == 0) MoveDrill(at(hole, 8, 0), at(hole, 9.5, 0), false, meter, time_s);
    MoveDrill(at(hole, depth_mm, 0), at(hole, -3, 0), false, meter, time_s);
    MoveDrill(at(hole, -3, 4), at(hole, 12, 4), false, meter, time_s);
    MoveDrill(at(hole, -3, 7.5), at(hole, 12, 7.5), true, meter, time_s);
  }
  const std::vector<std::optional<Pose>> deepest = meter.FindDeepest(bone, holes);
  ASSERT_EQ(deepest.size(), 2U);
  ASSERT_TRUE(deepest[0] && deepest[1]);
  // A row is kept every 4 ms, which is 0.04 mm.
  EXPECT_NEAR(glm::distance(deepest[0]->p_AB, at(0, 9.5, 0).p_AB), 0, 0.05);
  EXPECT_NEAR(glm::distance(deepest[1]->p_AB, at(1, 4, 0).p_AB), 0, 0.05);
}

/// The tool moves, turns and rests near a canal. Poses that cannot change a measure are left out, without an effect on
/// it.
TEST(MotionMeter, DistanceToTheNerveIsThatOfAllPoses) {
  BlockParams block;
  block.size_mm = {16, 10, 8};
  block.voxel_mm = 0.25;
  block.layers = {{6, 24}, {2, 34}};
  const RegionDistance nerve(MakeBlock(block, DefaultMandibleTable()), Tissue::kCanal);
  DiscSaw saw;
  MotionMeter meter(0);
  double min_mm = 1e9;
  double near_s = 0;
  std::mt19937 random(45);
  std::uniform_real_distribution<double> draw(-1, 1);
  constexpr double kRow_s = 0.004;
  constexpr int kEvery = 5;  // rows between two distances
  Pose X{glm::angleAxis(1.5, Vec3(1, 0, 0)), {0, 0, 6}};
  Vec3 v{0, 0, -0.02};
  for (int i = 0; i < 4000; ++i) {
    if (i % 200 == 0) v = {0.02 * draw(random), 0.02 * draw(random), 0.02 * draw(random)};
    if (i / 200 % 3 != 2) {
      X.p_AB += v;
      X.p_AB.z = std::clamp(X.p_AB.z, 4.0, 18.0);
      X.R_AB = glm::normalize(glm::angleAxis(0.002 * draw(random), glm::normalize(Vec3(draw(random), 1, 0))) * X.R_AB);
    }
    MotionTick tick;
    tick.time_s = i * kRow_s;
    tick.dt_s = kRow_s;
    tick.X_WT = X;
    meter.Take(tick);
    if (i % kEvery != 0) continue;
    const double distance_mm = nerve.Calc(saw, X);
    min_mm = std::min(min_mm, distance_mm);
    if (distance_mm < 2 && i > 0) near_s += kEvery * kRow_s;
  }
  ScoreSheet sheet = MakeSheet({});
  meter.Finish(saw, {}, &nerve, {}, sheet);
  EXPECT_EQ(sheet.Get("nerve_distance_mm").value(), min_mm);
  EXPECT_NEAR(sheet.Get("near_miss_s").value(), near_s, 1e-9);
  EXPECT_GT(near_s, 0.5);
  EXPECT_LT(near_s, 15);
}

}  // namespace
}  // namespace kerf
