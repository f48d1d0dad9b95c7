// The disc in its kerf: the walls hold it, let it slide, make it bind when it is tilted, and release it. It never
// passes through bone, however the handle moves.
#include <gtest/gtest.h>

#include <numbers>

#include "cut/hand_sim/hands.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::BlockPoses;
using test::DiscParams;
using test::DiscPose;
using test::Handle;

/// A saw that has been lowered by `depth` into a block whose top is at z = 4 in the block's frame; afterwards the
/// handle rests.
struct InKerf {
  InKerf(const Pose& the_X_WB, double voxel_mm, double depth, const CoupledParams& params = DiscParams())
      : X_WB(the_X_WB),
        simulation(test::MakeBox(X_WB, {22, 2, 8}, voxel_mm), params, DiscPose(X_WB, {0, 0, 4 + kR + 0.1})),
        p_B(0, 0, 4 + kR - depth) {
    double z = 4 + kR + 0.1;
    for (int i = 0; i < 8000 && out.X_WT.p_AB != DiscPose(X_WB, p_B).p_AB; ++i) {
      z = std::max(z - 0.004, p_B.z - 1);
      out = simulation.Tick(Handle(DiscPose(X_WB, {0, 0, z})));
      if (X_WB.InversePoint(out.X_WT.p_AB).z <= p_B.z) break;
    }
    p_B = X_WB.InversePoint(out.X_WT.p_AB);
    Hold(50);
  }
  CoupledOutput Hold(int ticks, const Vec3& offset_B = Vec3(0), double tilt_rad = 0, double rpm = 7500) {
    for (int i = 0; i < ticks; ++i) {
      Pose X_WH = DiscPose(X_WB, p_B + offset_B);
      X_WH.R_AB = X_WH.R_AB * glm::angleAxis(tilt_rad, Vec3(1, 0, 0));  // rotation about the length of the kerf
      out = simulation.Tick(Handle(X_WH, rpm));
    }
    return out;
  }
  Vec3 Place() const { return X_WB.InversePoint(out.X_WT.p_AB); }

  Pose X_WB;
  CoupledSimulation simulation;
  Vec3 p_B;
  CoupledOutput out;
};

TEST(CoupledKerf, WallsDoNotResistAStraightFeed) {
  // The kerf is exactly as wide as the disc: neither the cells of the grid nor the disc's position in them may jam it.
  for (const double h : {0.05, 0.1, 0.2, 0.25}) {
    const std::vector<Pose> poses = BlockPoses(h);
    for (const std::size_t n : {0u, 1u, 3u, 4u, 5u, 6u, 7u}) {
      if (h < 0.1 && n != 5 && n != 0) continue;  // with small voxels the bones are large
      CoupledSimulation simulation(test::MakeBox(poses[n], {22, 2, 8}, h), DiscParams(),
                                   DiscPose(poses[n], {-22.5, 0, 4 + kR - 3}));
      double max_N = 0;
      double engaged = 0;
      for (int i = 0; i < 1500; ++i) {
        const CoupledOutput out = simulation.Tick(Handle(DiscPose(poses[n], {-22.5 + 0.006 * i, 0, 4 + kR - 3})));
        max_N = std::max(max_N, glm::length(out.f_face_W_N) + glm::length(out.f_friction_W_N));
        engaged = std::max(engaged, out.engaged_teeth);
      }
      EXPECT_GT(engaged, 1);
      EXPECT_LT(max_N, 1e-3) << h << " " << n;
    }
  }
}

TEST(CoupledKerf, WallsHoldASidewaysPush) {
  for (const double h : {0.1, 0.2}) {
    CoupledParams params = DiscParams();
    SetEffect(params.effects, "kerf_friction", "coefficient", 0);  // otherwise it would run away along the kerf
    params.coupling.p_TC_mm = {0, kR - 1.5, 0};                    // pushed at the middle of the buried part
    InKerf kerf(BlockPoses(h)[5], h, 3, params);
    const Vec3 before = kerf.Place();
    for (const double side : {-1.0, 1.0}) {
      kerf.Hold(300, {0, 5 * side, 0});
      const double push_N = side * glm::dot(kerf.out.f_H_W_N, kerf.X_WB.Vector({0, -1, 0}));
      EXPECT_NEAR(push_N, 5, 0.01);
      // The play is 0.2 % of a voxel; in addition, 5 N act on about 20 points with 3000 N/mm each.
      EXPECT_NEAR(kerf.Place().y, before.y, 0.002 * h + 0.0005);
      EXPECT_NEAR(glm::dot(kerf.out.f_face_W_N, kerf.X_WB.Vector({0, -side, 0})), push_N, 0.05);
    }
  }
}

TEST(CoupledKerf, WallTorqueGrowsAndVanishesWithTheTilt) {
  CoupledParams params = DiscParams();
  SetEffect(params.effects, "kerf_friction", "coefficient", 0);
  InKerf kerf(BlockPoses(0.1)[4], 0.1, 3, params);
  double last = 0;
  for (const double tilt : {0.001, 0.002, 0.004, 0.006}) {
    for (const double sign : {1.0, -1.0}) {
      kerf.Hold(200, Vec3(0), sign * tilt);
      // The torque on the hand opposes the tilt: it is about -x of the block for a rotation about the tool's +x, which
      // is the same axis.
      const double torque = -sign * glm::dot(kerf.out.tau_H_W_Nmm, kerf.X_WB.Vector({1, 0, 0}));
      EXPECT_GT(torque, sign > 0 ? last : 0.9 * last);
      EXPECT_GT(torque, 0.5 * params.coupling.torsion_Nmm_per_rad * tilt);  // the walls take more than half of it
      if (sign < 0) last = torque;
    }
  }
  kerf.Hold(300);
  EXPECT_LT(glm::length(kerf.out.tau_H_W_Nmm), 0.5);
  EXPECT_LT(glm::length(kerf.out.f_H_W_N), 0.01);
}

TEST(CoupledKerf, SlidesAlongAWallWithCoulombFriction) {
  // The spindle is stopped, and the disc is pushed sideways with 5 N and pulled along the kerf. It sticks up to a pull
  // of mu N and slides at mu N.
  for (const double mu : {0.1, 0.3}) {
    CoupledParams params = DiscParams();
    SetEffect(params.effects, "kerf_friction", "coefficient", mu);
    params.coupling.p_TC_mm = {0, kR - 1.5, 0};
    params.coupling.torsion_Nmm_per_rad = 1e6;  // prevents rotation by the wall's friction
    params.coupling.max_torque_Nmm = 1e5;
    InKerf kerf(Pose{}, 0.1, 3, params);
    for (int i = 1; i <= 3000; ++i) kerf.Hold(1, {0.0017 * i, 0, -0.5});  // makes the kerf longer
    kerf.p_B = kerf.Place();
    ASSERT_GT(kerf.p_B.x, 3);
    // Back from the kerf's end and off its floor, so that the stopped rim touches nothing.
    kerf.Hold(200, {0, 5, 0.5}, 0, 0);
    for (int i = 1; i <= 500; ++i) kerf.Hold(1, {-0.002 * i, 5, 0.5}, 0, 0);
    // If pulled with less than mu N it does not move, except for creep: at 0.8 of the limit, v / sqrt(v^2 + c^2) = 0.8,
    // so it creeps at v = 4/3 of 0.02 mm/s for 0.3 s.
    const double offset = kerf.Place().x - kerf.p_B.x - 0.8 * mu * 5;
    kerf.Hold(50, {offset, 5, 0.5}, 0, 0);
    const double x = kerf.Place().x;
    kerf.Hold(300, {offset, 5, 0.5}, 0, 0);
    EXPECT_NEAR(kerf.Place().x, x, 0.3 * 0.02 * 4 / 3 * 1.05);
    for (int i = 1; i <= 1500; ++i) kerf.Hold(1, {-1 - 0.002 * i, 5, 0.5}, 0, 0);
    const double N = -glm::dot(kerf.out.f_face_W_N, kerf.X_WB.Vector({0, 1, 0}));
    EXPECT_NEAR(N, 5, 0.02);
    EXPECT_NEAR(glm::dot(kerf.out.f_H_W_N, kerf.X_WB.Vector({1, 0, 0})), mu * N, 0.02 * mu * N);
  }
}

class CoupledJump : public testing::TestWithParam<double> {};

TEST_P(CoupledJump, StoppedDiscPassesThroughNoBone) {
  // A plate 1 mm thick across z. The handle jumps through it, edge on and flat on, and stays there for one second.
  const double jump = GetParam();
  const Bone bone = test::MakeBox(Pose{}, {40, 30, 1}, 0.2);
  const std::uint64_t hash = bone.CalcHash();
  for (const bool flat : {false, true}) {
    const double reach = flat ? 0.125 : kR;
    Pose start = DiscPose(Pose{}, {0, 0, 0.5 + reach + 0.7});
    if (flat) start.R_AB = Quat(1, 0, 0, 0);
    CoupledSimulation simulation(bone, DiscParams(), start);
    Pose X_WH = start;
    X_WH.p_AB.z -= jump;
    for (int i = 0; i < 1000; ++i) {
      const CoupledOutput out = simulation.Tick(Handle(X_WH, 0));
      ASSERT_LE(glm::length(out.f_H_W_N), 40 * (1 + 1e-12));
      // Up to 40 N press on one edge point with 2000 N/mm; the resolution of a substep of half a voxel is added.
      ASSERT_GT(out.X_WT.p_AB.z, 0.5 + reach - 0.06) << i;
    }
    const CoupledOutput out = simulation.Tick(Handle(X_WH, 0));
    if (jump > 1) {
      EXPECT_NEAR(out.f_H_W_N.z, std::min(40.0, jump - 0.7), 0.1);
    }
    EXPECT_EQ(simulation.UpdateBone().CalcHash(), hash);
  }
}

TEST_P(CoupledJump, TurningDiscSkipsNoBone) {
  // The handle jumps through a thin plate, edge on: the space that the disc has swept is removed.
  const double jump = GetParam() + kR;
  CoupledParams params = DiscParams();
  params.coupling.max_force_N = 200;
  Bone bone = test::MakeBox(Pose{}, {40, 3, 1}, 0.2);
  bone.set_materials(test::OneRegionTable(24, 100, 0.28));  // soft, so that the disc gets through
  CoupledSimulation simulation(bone, params, DiscPose(Pose{}, {0, 0, 0.5 + kR + 0.7}));
  const Pose X_WH = DiscPose(Pose{}, {0, 0, 0.5 + kR + 0.7 - jump});
  double low = 1e9;
  for (int i = 0; i < 3000; ++i) low = std::min(low, simulation.Tick(Handle(X_WH)).X_WT.p_AB.z);
  const Bone& after = simulation.UpdateBone();
  int checked = 0;
  for (double x = -9; x <= 9; x += 0.37) {
    for (double z = -0.45; z <= 0.45; z += 0.1) {
      if (z < low - std::sqrt(kR * kR - x * x) + 0.2) continue;  // the disc has not reached this voxel
      if (z > 0.3) continue;                                     // the plate's edge is rounded
      EXPECT_GT(after.SignedDistance({x, 0, z}), 0.05) << x << " " << z << " " << low;
      ++checked;
    }
  }
  EXPECT_GT(checked, 100);
}

INSTANTIATE_TEST_SUITE_P(Jumps, CoupledJump, testing::Values(1.0, 5.0, 20.0, 100.0));

TEST(CoupledJump, NinetyDegreesInATickMakeNoSpike) {
  for (const double rpm : {0.0, 7500.0}) {
    InKerf kerf(Pose{}, 0.2, 3);
    for (int n = 0; n < 4; ++n) {
      for (int i = 0; i < 100; ++i) {
        kerf.Hold(1, Vec3(0), n % 2 == 0 ? std::numbers::pi / 2 : 0.0, rpm);
        ASSERT_LE(glm::length(kerf.out.f_H_W_N), 40 * (1 + 1e-12));
        ASSERT_LE(glm::length(kerf.out.tau_H_W_Nmm), 4000 * (1 + 1e-12));
        ASSERT_TRUE(IsValid(kerf.out.X_WT));
        ASSERT_LE(kerf.out.substeps, 24);
      }
    }
  }
}

TEST(CoupledSetDown, InsideBoneItIsNotThrownOut) {
  const Bone bone = test::MakeBox(Pose{}, {30, 10, 8}, 0.2);
  CoupledSimulation simulation(bone, DiscParams(), DiscPose(Pose{}, {0, 0, 40}));
  const Pose X = DiscPose(Pose{}, {0, 0, 4 + kR - 3});
  ASSERT_TRUE(simulation.SetDown(X));
  for (const double rpm : {0.0, 7500.0}) {
    for (int i = 0; i < 500; ++i) {
      const CoupledOutput out = simulation.Tick(Handle(X, rpm));
      ASSERT_LT(glm::length(out.X_WT.p_AB - X.p_AB), 0.01);
      ASSERT_LT(glm::length(out.f_H_W_N), 0.01);
    }
  }
}

}  // namespace
}  // namespace kerf
