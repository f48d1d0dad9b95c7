// The guide: its walls have a known stiffness, are never crossed, yield at a known force, and never push actively.
#include "cut/effects/guide.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "base/core/hash.h"
#include "cut/effects/plan.h"
#include "cut/hand_sim/internals.h"
#include "kerf/coupled.h"
#include "kerf/error.h"
#include "kerf/simulation.h"
#include "support/solids.h"

namespace kerf {
namespace {

constexpr double kRadius_mm = 11;

struct Wanted {
  double stiffness_N_per_mm = 5;
  double tolerance_mm = 0.5;
  double max_force_N = 100;
  double depth_mm = 0;
  double slot_mm = 0;
};

CoupledParams MakeParams(const Wanted& wanted) {
  CoupledParams params;
  params.effects.clear();
  params.coupling.max_force_N = 40;
  SetEffect(params.effects, "guide", "stiffness_N_per_mm", wanted.stiffness_N_per_mm);
  SetEffect(params.effects, "guide", "tolerance_mm", wanted.tolerance_mm);
  SetEffect(params.effects, "guide", "max_force_N", wanted.max_force_N);
  SetEffect(params.effects, "guide", "depth_mm", wanted.depth_mm);
  SetEffect(params.effects, "guide", "slot_length_mm", wanted.slot_mm);
  SetEffect(params.effects, "guide", "normal", EffectValue(Vec3(0, 0, 2)));  // the length of the vector does not matter
  SetEffect(params.effects, "guide", "depth_direction", EffectValue(Vec3(0, -1, 0)));
  return params;
}

/// The disc lies in the plane z = 0, its spindle along z; the bone is far below it.
class Guided {
 public:
  explicit Guided(const CoupledParams& params, const Pose& start = {})
      : simulation(test::MakeBox(Pose{{1, 0, 0, 0}, {0, 0, -200}}, {10, 10, 4}, 0.4), params, start) {}

  CoupledOutput Hold(const Pose& X_WH, int ticks = 200) {
    CoupledOutput out;
    for (int i = 0; i < ticks; ++i) out = simulation.Tick({.X_WH = X_WH});
    return out;
  }
  double Channel(std::size_t i) const {
    std::array<double, 4> values{};
    EffectsOf(simulation).Report(values);
    return values[i];
  }

  CoupledSimulation simulation;
};

Pose At(const Vec3& p, double about_x_rad = 0) {
  return {Quat(std::cos(0.5 * about_x_rad), std::sin(0.5 * about_x_rad), 0, 0), p};
}

TEST(Guide, HoldsAcrossThePlaneWithItsStiffness) {
  for (const double k : {0.5, 5.0, 500.0}) {
    for (const double side : {-1.0, 1.0}) {
      const CoupledParams params = MakeParams({.stiffness_N_per_mm = k, .max_force_N = 1000});
      Guided tool(params);
      const double K = params.coupling.stiffness_N_per_mm;
      // Within the tolerance the force is exactly zero.
      EXPECT_EQ(tool.Hold(At({0, 0, side * 0.49})).f_H_W_N, Vec3(0));
      const CoupledOutput out = tool.Hold(At({3, 2, side * 4}));
      // The coupling and the wall are two springs in series. The solver stops at a residual of 1e-8 of the forces.
      const double force_N = K * k / (K + k) * 3.5;
      EXPECT_NEAR(out.f_H_W_N.z, -side * force_N, 1e-6 * force_N) << k;
      EXPECT_NEAR(glm::length(Vec3(out.f_H_W_N.x, out.f_H_W_N.y, 0)), 0, 1e-6) << k;
      EXPECT_NEAR(out.X_WT.p_AB.z, side * (0.5 + force_N / k), 1e-6);
      EXPECT_NEAR(tool.Channel(3), force_N, 1e-6 * force_N);
      EXPECT_NEAR(tool.Channel(0), 0.5 + force_N / k, 1e-6);
    }
  }
}

TEST(Guide, LimitsTheDiscsTilt) {
  const CoupledParams params = MakeParams({.stiffness_N_per_mm = 5, .max_force_N = 1000});
  Guided tool(params);
  const double turned = 0.3;
  const CoupledOutput out = tool.Hold(At({}, turned), 400);
  // Two of the rim's four points, those on the y axis, are off the plane; each has the stiffness k / 4.
  const double phi = 2 * std::asin(out.X_WT.R_AB.x);
  const double away_mm = kRadius_mm * std::sin(phi) - 0.5;
  const double held_Nmm = 2 * (5.0 / 4) * away_mm * kRadius_mm * std::cos(phi);
  EXPECT_GT(phi, 0.05);
  EXPECT_LT(phi, 0.29);
  const double torsion_Nmm = params.coupling.torsion_Nmm_per_rad * (turned - phi);
  EXPECT_NEAR(held_Nmm, torsion_Nmm, 1e-6 * torsion_Nmm);
  EXPECT_NEAR(out.tau_H_W_Nmm.x, -torsion_Nmm, 1e-6 * torsion_Nmm);
  EXPECT_NEAR(tool.Channel(1), phi * 180 / std::numbers::pi, 1e-6);
}

TEST(Guide, StopsAtTheDepthAndAtTheSlotsEnds) {
  const double k = 100;
  Guided tool(MakeParams({.stiffness_N_per_mm = k, .max_force_N = 1000, .depth_mm = 15, .slot_mm = 12}));
  // The disc's lowest point is 11 mm below its centre, for any rotation about the normal of the depth.
  CoupledOutput out = tool.Hold(At({0, -4 - 10, 0}));
  const double force_N = 1 * k / (1 + k) * 10;
  EXPECT_NEAR(out.f_H_W_N.y, force_N, 1e-6);
  EXPECT_NEAR(out.X_WT.p_AB.y, -4 - force_N / k, 1e-6);
  EXPECT_NEAR(tool.Channel(2), 15 + force_N / k, 1e-6);
  for (const double side : {-1.0, 1.0}) {
    out = tool.Hold(At({side * (6 + 10), 0, 0}), 400);
    EXPECT_NEAR(out.f_H_W_N.x, -side * force_N, 1e-6);
    EXPECT_NEAR(out.X_WT.p_AB.x, side * (6 + force_N / k), 1e-6);
  }
}

const FissureBur kBur{.diameter_mm = 2.4, .length_mm = 8};

/// The bur points along -y, with its axis turned in the plane and out of it.
Quat Lean(double in_plane_rad, double out_of_plane_rad) {
  return glm::angleAxis(in_plane_rad, Vec3(0, 0, 1)) *
         glm::angleAxis(out_of_plane_rad - 0.5 * std::numbers::pi, Vec3(1, 0, 0));
}

TEST(Guide, StopsABurAtTheDeepestPointOfItsEnd) {
  const double k = 100;
  for (const double lean_rad : {0.0, 0.3, -0.6}) {
    CoupledParams params = MakeParams({.stiffness_N_per_mm = k, .max_force_N = 1000, .depth_mm = 15});
    params.tool = kBur;
    const Quat R = Lean(lean_rad, 0);
    Guided tool(params, Pose{R, Vec3(0)});
    const CoupledOutput out = tool.Hold({R, {0, -25, 0}}, 400);
    // The edge of the flat end is as far below the tip as the axis leans.
    const double axis_y = out.X_WT.Vector({0, 0, 1}).y;
    const double deepest_mm = -out.X_WT.p_AB.y + kBur.radius_mm() * std::sqrt(std::max(0.0, 1 - axis_y * axis_y));
    EXPECT_GT(tool.Channel(3), 5);
    EXPECT_NEAR(deepest_mm, 15 + tool.Channel(3) / k, 1e-6) << lean_rad;
    EXPECT_NEAR(tool.Channel(2), deepest_mm, 1e-9) << lean_rad;
  }
}

TEST(Guide, HoldsBothEndsOfABursAxisInThePlane) {
  const double k = 5;
  CoupledParams params = MakeParams({.stiffness_N_per_mm = k, .max_force_N = 1000});
  params.tool = kBur;
  Guided tool(params, Pose{Lean(0, 0), Vec3(0)});
  for (const Pose& X : {Pose{Lean(0, 0), {0, 0, 3}}, Pose{Lean(0, 0.3), {0, 0, 2}}, Pose{Lean(0, -0.5), Vec3(0)}}) {
    const CoupledOutput out = tool.Hold(X, 400);
    const double tip_mm = out.X_WT.p_AB.z;
    const double top_mm = out.X_WT.Point({0, 0, kBur.length_mm}).z;
    EXPECT_NEAR(tool.Channel(0), std::max(std::abs(tip_mm), std::abs(top_mm)), 1e-9);
    // Each end has half of the stiffness, beyond the tolerance.
    double force_N = 0;
    for (const double z_mm : {tip_mm, top_mm}) {
      force_N -= 0.5 * k * std::copysign(std::max(std::abs(z_mm) - 0.5, 0.0), z_mm);
    }
    EXPECT_GT(std::abs(force_N), 0.5);
    EXPECT_NEAR(out.f_H_W_N.z, force_N, 1e-5);
  }
}

TEST(Guide, IsNeverCrossedHoweverTheHandJumps) {
  const double k = 50;
  const CoupledParams params = MakeParams({.stiffness_N_per_mm = k, .max_force_N = 1000, .depth_mm = 15});
  Guided tool(params);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> shift(-100, 100), turn(-1.5, 1.5);
  double furthest_mm = 0, deepest_mm = 0, jumped_mm = 0;
  for (int i = 0; i < 1500; ++i) {
    const Pose X_WH = At({shift(random), shift(random), shift(random)}, turn(random));
    const CoupledOutput out = tool.Hold(X_WH, 1 + i % 7);
    furthest_mm = std::max(furthest_mm, tool.Channel(0));
    deepest_mm = std::max(deepest_mm, tool.Channel(2));
    jumped_mm = std::max(jumped_mm, glm::length(X_WH.p_AB - out.X_WT.p_AB));
    ASSERT_LE(glm::length(out.f_H_W_N), 40 * (1 + 1e-9));
  }
  EXPECT_GT(jumped_mm, 90);
  // The coupling exerts at most 40 N and 4000 N mm. If both act on one point of the rim, of stiffness k / 4, the force
  // there is 40 + 4000 / 11 N.
  EXPECT_LT(furthest_mm, 0.5 + (40 + 4000 / kRadius_mm) / (k / 4));
  EXPECT_GT(furthest_mm, 0.5 + 40 / k);
  // The same applies to the stop, with k.
  EXPECT_LT(deepest_mm, 15 + (40 + 4000 / kRadius_mm) / k);
}

TEST(Guide, YieldsAtItsMaximumForce) {
  Guided tool(MakeParams({.stiffness_N_per_mm = 5, .max_force_N = 6}));
  const CoupledOutput pulled = tool.Hold(At({0, 0, 30}), 600);
  EXPECT_NEAR(pulled.f_H_W_N.z, -6, 1e-6);
  EXPECT_NEAR(pulled.X_WT.p_AB.z, 30 - 6, 1e-5);
  // A guide that has yielded does not pull the tool back: its wall stays where it was pushed, and moves back with the
  // tool.
  const CoupledOutput back = tool.Hold(At({0, 0, 10}), 600);
  EXPECT_EQ(back.f_H_W_N, Vec3(0));
  const CoupledOutput again = tool.Hold(At({0, 0, 11}), 600);
  EXPECT_NEAR(again.f_H_W_N.z, -1.0 * 5 / 6, 1e-6);
}

TEST(Guide, ToolSetDownOffThePlanIsNotPulledTowardsIt) {
  Guided tool(MakeParams({}));
  ASSERT_TRUE(tool.simulation.SetDown(At({0, 0, 40}, 0.5)));
  EXPECT_EQ(tool.Hold(At({0, 0, 40}, 0.5)).f_H_W_N, Vec3(0));
  EXPECT_LT(glm::length(tool.Hold(At({0, 0, 20}, 0.2)).f_H_W_N), 1e-9);  // rounding error
  EXPECT_LT(tool.Hold(At({0, 0, 22}, 0.2)).f_H_W_N.z, -1);
}

TEST(Guide, ReturnsNoMoreEnergyThanWasPutIn) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> shift(-1, 1);
  double put_in_mJ = 0, min_mJ = 0;
  for (int seed = 0; seed < 10; ++seed) {
    Guided tool(MakeParams({.stiffness_N_per_mm = seed % 2 == 0 ? 5.0 : 200.0,
                            .max_force_N = seed < 5 ? 1000.0 : 8.0,
                            .depth_mm = 12,
                            .slot_mm = 3}));
    Vec3 p(0);
    double turned = 0, sum_mJ = 0;
    for (int i = 0; i < 3000; ++i) {
      p = 0.995 * p + Vec3(shift(random), shift(random), shift(random)) * 0.4;
      turned = 0.99 * turned + 0.02 * shift(random);
      const CoupledOutput out = tool.Hold(At(p, turned), 1);
      sum_mJ += out.hand_mJ - out.stored_mJ;
      put_in_mJ += std::abs(out.hand_mJ);
      min_mJ = std::min(min_mJ, sum_mJ);
      ASSERT_EQ(out.spindle_mJ, 0);
    }
  }
  EXPECT_GT(put_in_mJ, 100);
  // Steps are linear, but the points of the disc move on arcs, which causes an error of about 1e-6 of the exchanged
  // energy.
  EXPECT_GT(min_mJ, -1e-6 * put_in_mJ);
}

TEST(Guide, CutFarFromItIsBitIdentical) {
  const auto cut = [](bool guided) {
    CoupledParams params;
    if (guided) SetEffect(params.effects, "guide", "tolerance_mm", 60);
    CoupledSimulation simulation(test::MakeBox(Pose{}, {30, 12, 6}, 0.4), params, At({0, 16, 0}));
    std::uint64_t hash = 1;
    for (int i = 0; i < 800; ++i) {
      const CoupledOutput out = simulation.Tick({.X_WH = At({0, 16 - 0.01 * i, 0})});
      for (int axis = 0; axis < 3; ++axis) hash = MixHash(hash ^ std::bit_cast<std::uint64_t>(out.f_H_W_N[axis]));
    }
    return std::pair(hash, simulation.UpdateBone().CalcHash());
  };
  EXPECT_EQ(cut(true), cut(false));
}

TEST(Guide, OnAPathItsForceFollowsTheDeviation) {
  SimulationParams params;
  params.effects = MakeParams({.stiffness_N_per_mm = 5, .max_force_N = 1000}).effects;
  Simulation simulation(test::MakeBox(Pose{{1, 0, 0, 0}, {0, 0, -200}}, {10, 10, 4}, 0.4), params, At({}));
  TickOutput out;
  for (int i = 1; i <= 250; ++i) out = simulation.Tick({At({0, 0, 0.01 * i})});
  EXPECT_NEAR(out.f_T_W_N.z, -5 * (2.5 - 0.5), 1e-9);
}

TEST(Guide, RefusesInvalidDirections) {
  CoupledParams params = MakeParams({});
  SetEffect(params.effects, "guide", "normal", EffectValue(Vec3(0)));
  EXPECT_THROW(Guided{params}, Error);
  SetEffect(params.effects, "guide", "normal", EffectValue(Vec3(0, 1, 0)));  // parallel to the depth
  EXPECT_THROW(Guided{params}, Error);
}

}  // namespace
}  // namespace kerf
