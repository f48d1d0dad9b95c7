// What holds the tool meets bone: the springs have a known stiffness and direction, hold however the hand moves, never
// push actively, and cut nothing; the fast search finds what a search of all points finds.
#include "cut/tool/handpiece.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numbers>
#include <random>

#include "base/core/hash.h"
#include "base/core/heap_guard.h"
#include "cut/effects/handpiece/holder_points.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "cut/tool/disc_saw.h"
#include "kerf/coupled.h"
#include "kerf/simulation.h"
#include "support/cuts.h"

namespace kerf {
namespace {

constexpr std::size_t kForce = 0, kHubForce = 1, kDepth = 2;  // channels

CoupledParams MakeHolderParams(const Tool& tool = DiscSaw{}, double stiffness_N_per_mm = 1000) {
  CoupledParams params;
  params.tool = tool;
  params.effects.clear();
  SetEffect(params.effects, "handpiece", "stiffness_N_per_mm", stiffness_N_per_mm);
  return params;
}

/// Section of the handle with the largest radius.
HolderSection FindWidest(const Tool& tool) {
  const std::vector<HolderSection> sections = MakeHandpiece(tool).sections;
  return *std::max_element(sections.begin(), sections.end(),
                           [](const auto& a, const auto& b) { return a.radius_mm < b.radius_mm; });
}

class HeldByWall {
 public:
  HeldByWall(const Bone& bone, const CoupledParams& params, const Pose& start = {}) : simulation(bone, params, start) {}

  CoupledOutput Hold(const Pose& X_WH, int ticks = 300, double rpm = 7500) {
    CoupledOutput out;
    for (int i = 0; i < ticks; ++i) {
      const HeapGuard guard;
      out = simulation.Tick({.X_WH = X_WH, .rpm = rpm});
      removed_mm3 += out.removed_mm3;
    }
    return out;
  }
  double Channel(std::size_t i) const {
    std::array<double, 3> values{};
    EffectsOf(simulation).Report(values);
    return values[i];
  }

  CoupledSimulation simulation;
  double removed_mm3 = 0;
};

Pose HolderAt(const Vec3& p, double about_y_rad = 0) {
  return {glm::angleAxis(about_y_rad, Vec3(0, 1, 0)), p};
}

/// A wall of bone at `gap_mm` from the widest place of the handle, on the side of +x. The disc is far from it.
struct HolderWall {
  explicit HolderWall(double gap_mm, double voxel_mm = 0.4)
      : widest(FindWidest(DiscSaw{})),
        bone(test::MakeBox({{1, 0, 0, 0}, {widest.radius_mm + gap_mm + 5, 0, widest.middle_T.z}}, {10, 16, 20},
                           voxel_mm)) {}
  HolderSection widest;
  Bone bone;
};

TEST(Handpiece, AWallHoldsTheHandleWithTheStiffnessOfOnePoint) {
  const HolderWall wall(0.7);
  for (const double k : {200.0, 1000.0, 50'000.0}) {
    CoupledParams params = MakeHolderParams(DiscSaw{}, k);
    params.coupling.p_TC_mm = wall.widest.middle_T;  // so that the wall does not turn the tool
    HeldByWall tool(wall.bone, params);
    EXPECT_EQ(tool.Hold(HolderAt({0.65, 0.3, 0})).f_H_W_N, Vec3(0));
    const CoupledOutput out = tool.Hold(HolderAt({5.7, 0.3, 0}));
    // Of the widest ring, one point faces the wall. The coupling and its spring are in series; the force is normal to
    // the wall. The solver stops at 1e-8 of the forces; the distances are floats, with errors of 1e-7 mm.
    const double K = params.coupling.stiffness_N_per_mm;
    const double force_N = K * k / (K + k) * 5;
    const double error_N = 1e-6 * force_N + 1e-7 * k;
    EXPECT_NEAR(out.f_H_W_N.x, -force_N, error_N) << k;
    EXPECT_NEAR(out.f_H_W_N.y, 0, 1e-6) << k;
    EXPECT_NEAR(out.f_H_W_N.z, 0, 1e-6) << k;
    EXPECT_NEAR(out.X_WT.p_AB.x, 0.7 + force_N / k, 1e-5) << k;
    EXPECT_NEAR(tool.Channel(kForce), force_N, error_N) << k;
    EXPECT_EQ(tool.Channel(kHubForce), 0) << k;
    EXPECT_NEAR(tool.Channel(kDepth), force_N / k, 1e-5) << k;
    EXPECT_EQ(tool.removed_mm3, 0);
    EXPECT_EQ(tool.simulation.UpdateBone().CalcHash(), wall.bone.CalcHash());
    EXPECT_LT(glm::length(tool.Hold(HolderAt({0.65, 0.3, 0})).f_H_W_N), 1e-6);
  }
}

TEST(Handpiece, IsNeverPushedThroughAWallHoweverTheHandJumps) {
  const HolderWall wall(0.7);
  for (const bool at_disc : {false, true}) {
    CoupledParams params = MakeHolderParams();
    if (!at_disc) params.coupling.p_TC_mm = wall.widest.middle_T;
    HeldByWall tool(wall.bone, params);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> shift(-30, 30), turn(-0.4, 0.4);
    double deepest_mm = 0, jumped_mm = 0;
    for (int i = 0; i < 800; ++i) {
      // Beyond the wall, which the disc does not reach.
      const Pose X_WH = HolderAt({std::abs(shift(random)), 0.1 * shift(random), 0.05 * shift(random)}, turn(random));
      const CoupledOutput out = tool.Hold(X_WH, 1 + i % 5);
      deepest_mm = std::max(deepest_mm, tool.Channel(kDepth));
      jumped_mm = std::max(jumped_mm, glm::length(X_WH.p_AB - out.X_WT.p_AB));
      ASSERT_LE(glm::length(out.f_H_W_N), params.coupling.max_force_N * (1 + 1e-9));
    }
    EXPECT_GT(jumped_mm, 20);
    EXPECT_GT(deepest_mm, 0.01);
    // 40 N and 4000 N mm at 66 mm on one point of 1000 N/mm; and the depth that a spring does not take up at once,
    // because the tool slid along the bone.
    EXPECT_LT(deepest_mm, 0.1 + 0.4);
  }
}

TEST(Handpiece, RubsWithCoulombsFriction) {
  const HolderWall wall(0.7);
  CoupledParams params = MakeHolderParams();
  params.coupling.p_TC_mm = wall.widest.middle_T;
  SetEffect(params.effects, "handpiece", "friction", 0.3);
  HeldByWall tool(wall.bone, params);
  const CoupledOutput pressed = tool.Hold(HolderAt({5.7, 0, 0}));
  // It sticks, but for creep at 0.02 mm/s at most and a turn by the torque about z, up to 0.3 times the force; then it
  // slides.
  CoupledOutput out = tool.Hold(HolderAt({5.7, 0.5 * 0.3 * 5, 0}), 100);
  EXPECT_NEAR(out.X_WT.p_AB.y, 0, 0.01);
  for (int i = 0; i < 500; ++i) out = tool.Hold(HolderAt({5.7, 0.75 + 0.005 * i, 0}), 1);
  EXPECT_GT(out.X_WT.p_AB.y, 1);
  EXPECT_NEAR(out.f_H_W_N.y, 0.3 * pressed.f_H_W_N.x, 0.01);
  EXPECT_NEAR(out.f_H_W_N.x, pressed.f_H_W_N.x, 0.01);
}

TEST(Handpiece, IsNotTurnedThroughAThinPlate) {
  const BallBurr burr;
  const HolderSection widest = FindWidest(burr);
  const double z = widest.middle_T.z, gap_mm = 1;
  const Bone plate = test::MakeBox({{1, 0, 0, 0}, {widest.radius_mm + gap_mm + 0.5, 0, z}}, {1, 20, 30}, 0.2);
  CoupledParams params = MakeHolderParams(burr);
  params.coupling.stiffness_N_per_mm = 1000;  // the ball stays in its place
  HeldByWall tool(plate, params);
  // The hand turns the burr by 0.4 rad about the ball in one tick, which moves the handle by 20 mm.
  const CoupledOutput out = tool.Hold(HolderAt({}, 0.4), 300);
  const double turned_rad = 2 * std::asin(out.X_WT.R_AB.y);
  // It stops at the plate, the sooner the further it is from the ball.
  EXPECT_GT(turned_rad, 0.5 * gap_mm / z);
  EXPECT_LT(turned_rad, 1.5 * gap_mm / z);
  EXPECT_NEAR(out.tau_H_W_Nmm.y, -5000 * (0.4 - turned_rad), 1);
}

TEST(Handpiece, ADiscStopsAtItsHub) {
  const DiscSaw saw{.thickness_mm = 0.5};
  const DiscHub hub = CalcHub(saw);
  const double h = 0.2, half_mm = 6;
  const Bone block = test::MakeBox({}, {12, 5, 2 * half_mm}, h);
  const auto cut = [&](bool on) {
    CoupledParams params = MakeHolderParams(saw);
    params.coupling.stiffness_N_per_mm = 4;
    if (!on) params.effects.clear();
    const double start_z = half_mm + saw.radius_mm() + 0.3;
    CoupledSimulation simulation(block, params, test::DiscPose({}, {0, 0, start_z}));
    CoupledOutput out;
    // The handle goes 12 mm below the top at 10 mm/s, and stays there.
    for (int i = 0; i < 6000; ++i) {
      out = simulation.Tick({.X_WH = test::DiscPose({}, {0, 0, std::max(start_z - 0.01 * i, half_mm - 1)})});
    }
    std::array<double, 3> channels{};
    if (on) EffectsOf(simulation).Report(channels);
    return std::pair(out, channels);
  };
  const double free_mm = half_mm + saw.radius_mm() - cut(false).first.X_WT.p_AB.z;
  EXPECT_GT(free_mm, saw.radius_mm() + 0.5);  // it cuts to its centre
  const auto [out, channels] = cut(true);
  const double depth_mm = half_mm + saw.radius_mm() - out.X_WT.p_AB.z;
  // The lowest points of both flanges, two rings each, carry the push of the hand: at 1000 N/mm, 2 um. Half a voxel is
  // for the grid at the kerf's edge, where the flanges are.
  EXPECT_NEAR(depth_mm, saw.radius_mm() - hub.radius_mm, 0.5 * h);
  EXPECT_GT(channels[kHubForce], 2);
  EXPECT_NEAR(channels[kHubForce], out.f_H_W_N.z, 0.02 * out.f_H_W_N.z);
}

TEST(Handpiece, AShankIsFreeInItsHoleAndHeldByTheWall) {
  const FissureBur bur{.diameter_mm = 2.4, .length_mm = 8};
  const std::vector<HolderBody> bodies = MakeHolder(bur);
  const HolderBody& shank = bodies.front();
  ASSERT_EQ(shank.part, HolderBody::Part::kShank);
  const double radius = shank.sections.front().radius_mm;
  const double middle_z = 0.5 * (shank.sections.front().middle_T.z + shank.sections.back().middle_T.z);
  // A plate with a hole as wide as the bur, around the middle of the shank; the head has passed it.
  const double h = 0.1, thick_mm = 3.2;
  SolidField field;
  field.value = [&](const Vec3& p) {
    return std::max(test::BoxDistance(p - Vec3(0, 0, middle_z), {5, 5, 0.5 * thick_mm}),
                    bur.radius_mm() - std::hypot(p.x, p.y));
  };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3&) { return 24; };
  const Vec3 reach(5, 5, 0.5 * thick_mm);
  const Bone plate = MakeBone(field, Box3{Vec3(0, 0, middle_z) - reach, Vec3(0, 0, middle_z) + reach}.Grown(6 * h),
                              {h, h, {}}, test::OneRegionTable());
  CoupledParams params = MakeHolderParams(bur);
  params.coupling.p_TC_mm = {0, 0, middle_z};
  params.coupling.stiffness_N_per_mm = 4;
  HeldByWall tool(plate, params);
  const double free_mm = bur.radius_mm() - radius;
  // Each point is free up to the wall; the rest is rounding.
  EXPECT_LT(glm::length(tool.Hold(HolderAt({0.85 * free_mm, 0, 0}), 300, -7500).f_H_W_N), 1e-9);
  const CoupledOutput out = tool.Hold(HolderAt({free_mm + 2, 0, 0}), 300, -7500);
  // The shank is 5 mm long, its rings at most its radius apart. The wall's place is accurate to a tenth of a voxel.
  const double rings = std::floor(thick_mm / (5 / std::ceil(5 / radius)));
  const double in_mm = 4 * 2 / (1000 * rings);
  EXPECT_NEAR(out.X_WT.p_AB.x, free_mm + in_mm, 0.1 * h);
  EXPECT_NEAR(out.f_H_W_N.x, -4 * 2, 4 * 0.1 * h + 4 * in_mm);
  EXPECT_NEAR(out.f_H_W_N.y, 0, 0.01);
  EXPECT_EQ(tool.removed_mm3, 0);
}

TEST(Handpiece, ReturnsNoMoreEnergyThanWasPutIn) {
  const HolderWall wall(0.7);
  double put_in_mJ = 0, min_mJ = 0, loop_mJ = 0, force_N = 0;
  for (int seed = 0; seed < 10; ++seed) {
    CoupledParams params = MakeHolderParams(DiscSaw{}, seed % 2 == 0 ? 1000.0 : 50.0);
    params.coupling.p_TC_mm = {0, 0, seed < 5 ? 80.0 : 0.0};
    HeldByWall tool(wall.bone, params);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> shift(-1, 1);
    Vec3 p(0);
    double turned = 0, sum_mJ = 0, hand_mJ = 0;
    for (int i = 0; i < 3000; ++i) {
      p = 0.995 * p + Vec3(shift(random) + 0.05, shift(random), shift(random)) * 0.3;
      turned = 0.99 * turned + 0.004 * shift(random);
      const CoupledOutput out = tool.Hold(HolderAt(p, turned), 1);
      sum_mJ += out.hand_mJ - out.stored_mJ;
      hand_mJ += out.hand_mJ;
      put_in_mJ += std::abs(out.hand_mJ);
      min_mJ = std::min(min_mJ, sum_mJ);
      force_N = std::max(force_N, tool.Channel(kForce));
      ASSERT_EQ(out.spindle_mJ, 0);
    }
    // Back at the start, which closes the loop.
    for (int i = 0; i < 200; ++i) hand_mJ += tool.Hold(HolderAt({}), 1).hand_mJ;
    loop_mJ = std::min(loop_mJ, hand_mJ);
  }
  EXPECT_GT(force_N, 5);
  EXPECT_GT(put_in_mJ, 100);
  // As for the guide: points move on arcs and the step is straight.
  EXPECT_GT(min_mJ, -1e-6 * put_in_mJ);
  EXPECT_GT(loop_mJ, -1e-6 * put_in_mJ);
}

TEST(Handpiece, SetDownInBoneItIsNotThrownOut) {
  const HolderWall wall(-2);
  CoupledParams params = MakeHolderParams();
  params.coupling.p_TC_mm = wall.widest.middle_T;
  HeldByWall tool(wall.bone, params);
  EXPECT_EQ(tool.Hold(HolderAt({}), 50).f_H_W_N, Vec3(0));
  // It comes out freely, and is held on the way in.
  EXPECT_LT(glm::length(tool.Hold(HolderAt({-1, 0, 0}), 200).f_H_W_N), 0.01);
  EXPECT_LT(tool.Hold(HolderAt({4, 0, 0}), 200).f_H_W_N.x, -4);
}

TEST(Handpiece, FindsWhatASearchOfAllPointsFinds) {
  const double h = 0.4, reach_mm = 0.75 * h;
  Bone bone = test::MakeBox({glm::angleAxis(0.4, glm::normalize(Vec3(1, 2, 3))), {12, 0, 40}}, {8, 14, 30}, h);
  BoneField field(bone, 64);
  for (const Tool& tool : {Tool(DiscSaw{}), Tool(BallBurr{}), Tool(TwistDrill{}), Tool(OscillatingBlade{}),
                           Tool(ReciprocatingBlade{}), Tool(PiezoInsert{})}) {
    HolderPoints points(field, tool, 3);
    std::mt19937_64 random(11);
    std::normal_distribution<double> draw;
    // The middle of the points is at the bone's side.
    Vec3 middle_T(0);
    for (const auto& point : points.points()) middle_T += point.p_T / static_cast<double>(points.points().size());
    const Vec3 home_F = Vec3(6, 0, 40) - middle_T - field.p_WF_mm();
    Pose X{{1, 0, 0, 0}, home_F};
    int found_count = 0, clear_count = 0;
    for (int i = 0; i < 4000; ++i) {
      const double size = i % 50 == 0 ? 6 : 0.05;  // jumps now and then
      Pose next = X;
      next.p_AB += size * Vec3(draw(random), draw(random), draw(random));
      next.p_AB = glm::mix(next.p_AB, home_F, 0.01);
      const Vec3 turn = 0.1 * size * Vec3(draw(random), draw(random), draw(random)) / 6.0;
      next.R_AB = glm::normalize(next.R_AB * Quat(1, turn.x, turn.y, turn.z));
      if (points.IsClear(X, next)) {
        ++clear_count;
        for (int k = 0; k <= 4; ++k) {
          const Probe probe(field, Interpolate(X, next, 0.25 * k));
          for (const auto& point : points.points()) ASSERT_GT(probe.Distance(point.p_T), reach_mm);
        }
      }
      X = next;
      if (i % 3 == 0) continue;  // in air it is not asked
      const Probe probe(field, X);
      const auto found = points.Find(probe, reach_mm);
      std::size_t n = 0;
      for (std::size_t p = 0; p < points.points().size(); ++p) {
        const double distance_mm = probe.Distance(points.points()[p].p_T);
        if (distance_mm > reach_mm) continue;
        ASSERT_LT(n, found.size());
        ASSERT_EQ(found[n].point, static_cast<int>(p));
        ASSERT_EQ(found[n++].distance_mm, distance_mm);
      }
      ASSERT_EQ(n, found.size());
      found_count += static_cast<int>(n);
    }
    EXPECT_GT(found_count, 50) << GetShape(tool);
    EXPECT_GT(clear_count, 50) << GetShape(tool);
  }
}

TEST(Handpiece, HasABoundedNumberOfPoints) {
  Bone bone = test::MakeBox({}, {4, 4, 4}, 0.4);
  BoneField field(bone, 64);
  for (const double spacing_mm : {0.5, 3.0, 20.0}) {
    for (const Tool& tool :
         {Tool(DiscSaw{}), Tool(DiscSaw{.diameter_mm = 1}), Tool(DiscSaw{.diameter_mm = 70}), Tool(BallBurr{}),
          Tool(FissureBur{.diameter_mm = 0.5}), Tool(TwistDrill{}), Tool(TwistDrill{.diameter_mm = 0.3}),
          Tool(OscillatingBlade{}), Tool(ReciprocatingBlade{}), Tool(PiezoInsert{})}) {
      const HolderPoints points(field, tool, spacing_mm);
      EXPECT_LE(points.points().size(), HolderPoints::kMaxPoints);
      EXPECT_GT(points.points().size(), 100);
      for (const auto& point : points.points()) EXPECT_NEAR(glm::length(point.n_T), 1, 1e-12);
    }
  }
}

TEST(Handpiece, ACutThatItIsFarFromIsBitIdentical) {
  const auto cut = [](bool on) {
    CoupledParams params;
    if (on) params.effects = MakeHolderParams().effects;
    CoupledSimulation simulation(test::MakeBox(Pose{}, {30, 12, 6}, 0.4), params, HolderAt({0, 16, 0}));
    std::uint64_t hash = 1;
    for (int i = 0; i < 800; ++i) {
      const CoupledOutput out = simulation.Tick({.X_WH = HolderAt({0, 16 - 0.01 * i, 0})});
      for (int axis = 0; axis < 3; ++axis) hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(out.f_H_W_N[axis]));
    }
    return std::pair(hash, simulation.UpdateBone().CalcHash());
  };
  EXPECT_EQ(cut(true), cut(false));
}

TEST(Handpiece, OnAPathOnlyItsDepthIsMeasured) {
  const HolderWall wall(0.7);
  SimulationParams params;
  params.effects = MakeHolderParams().effects;
  Simulation simulation(wall.bone, params, HolderAt({}));
  TickOutput out;
  for (int i = 1; i <= 100; ++i) out = simulation.Tick({HolderAt({0.01 * i, 0, 0})});
  EXPECT_EQ(out.f_T_W_N, Vec3(0));
  std::array<double, 3> channels{};
  simulation.ReadChannels(channels);
  EXPECT_EQ(channels[kForce], 0);
  EXPECT_NEAR(channels[kDepth], 0.3 - 0.01, 1e-5);  // at the start of the tick
}

}  // namespace
}  // namespace kerf
