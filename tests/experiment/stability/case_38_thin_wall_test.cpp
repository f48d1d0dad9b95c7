// Hard case 38: two cuts with a wall of one voxel between them, and single voxels in the saw's way.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "bone/grid/build.h"
#include "cut/hand_sim/hands.h"
#include "experiment/stability/measures.h"
#include "experiment/stability/verdict.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscPose;
using test::Handle;
using test::PushingHand;
using test::Verdict;

constexpr double kThinWallVoxel = 0.2;
constexpr double kBeside = 0.25 + kThinWallVoxel;  // distance between the centres of the kerfs

/// Returns a block of 26 x 6 x 10 mm with its top at z = 5.
Bone MakeThinWallBlock() {
  return test::MakeBox(Pose{}, {26, 6, 10}, kThinWallVoxel);
}

/// Plunges at 3 mm/s to a handle depth of 6 mm at `y`.
std::vector<Vec3> Plunge(CoupledSimulation& simulation, double y) {
  std::vector<Vec3> f;
  const double clear = 5 + kR + 0.2;
  simulation.SetDown(DiscPose(Pose{}, {0, y, clear}));
  for (int i = 0; i < 2000; ++i) {
    f.push_back(simulation.Tick(Handle(DiscPose(Pose{}, {0, y, clear - 0.003 * i}))).f_H_W_N);
  }
  return f;
}

TEST(HardCase38, CutBesideACutIsAsInSolidBone) {
  Verdict verdict("holds: a wall is rigid until the rim removes it, however thin it is");
  CoupledSimulation simulation(MakeThinWallBlock(), test::DiscParams(), DiscPose(Pose{}, {0, 0, 5 + kR + 0.2}));
  const std::vector<Vec3> whole = Plunge(simulation, 0);
  const std::vector<Vec3> beside = Plunge(simulation, kBeside);
  double unlike = 0;
  double max_N = 0;
  for (std::size_t i = 500; i < whole.size(); ++i) {
    unlike = std::max(unlike, glm::length(beside[i] - whole[i]));
    max_N = std::max(max_N, whole[i].z);
  }
  EXPECT_GT(max_N, 1);
  verdict.AtMost("force difference next to the wall relative to solid bone", 100 * unlike / max_N, 7, "%");
  const std::vector<Vec3> steady(beside.begin() + 700, beside.end());
  verdict.AtMost("C1", 1000 * CalcNoise(steady, 0.001), 20, "mN");
  // The wall extends from slightly below the top to the end of the second cut. It is one voxel thick, to within a
  // quarter of that.
  const Bone& bone = simulation.UpdateBone();
  double thinnest = 1e9;
  for (double z = 4.6; z > 2.5; z -= 0.1) {
    double thick = 0;
    for (double y = 0.05; y < kBeside - 0.05; y += 0.005) thick += bone.SignedDistance({0, y, z}) < 0 ? 0.005 : 0;
    thinnest = std::min(thinnest, thick);
  }
  verdict.AtLeast("minimum wall thickness in voxels", thinnest / kThinWallVoxel, 0.75);
}

TEST(HardCase38, ThinWallHoldsAPushedSaw) {
  Verdict verdict(
      "holds, corrected: a look-up in such a thin wall ended behind it, and the disc passed through without force");
  for (const bool stopped : {false, true}) {
    CoupledSimulation simulation(MakeThinWallBlock(), test::DiscParams(), DiscPose(Pose{}, {0, 0, 5 + kR + 0.2}));
    Plunge(simulation, 0);
    Plunge(simulation, kBeside);
    const Pose X_start = simulation.Tick(Handle(DiscPose(Pose{}, {0, kBeside, 5 + kR - 3}), stopped ? 0 : 7500)).X_WT;
    // The handle moves 3 mm towards the first kerf, which gives 3 N, and half-way the spindle stops or starts.
    std::vector<Vec3> f;
    std::vector<double> across;
    CoupledOutput out;
    double worst_N = 0;
    for (int i = 0; i < 2500; ++i) {
      const double rpm = (i < 1250) == stopped ? 0 : 7500;
      const double push = std::min(3.0, 0.006 * i);
      out = simulation.Tick(Handle(DiscPose(Pose{}, {0, kBeside - push, 5 + kR - 3}), rpm));
      if (i > 600) worst_N = std::max(worst_N, glm::length(out.f_H_W_N - f.back()));
      f.push_back(out.f_H_W_N);
      if (i > 700) across.push_back(out.f_H_W_N.y);
    }
    EXPECT_NEAR(out.f_H_W_N.y, 3, 0.15);
    const char* first = stopped ? "spindle starts" : "spindle stops";
    // Half of the displacement is tilt: 3 N with a lever arm of about 9 mm on the coupling's 5000 N mm/rad. The wall is
    // 0.2 mm thick.
    verdict.AtMost(std::string(first) + ": tool displacement", std::abs(out.X_WT.p_AB.y - X_start.p_AB.y), 0.1, "mm");
    verdict.AtMost(std::string(first) + ": largest force step", worst_N, 0.2, "N");
    const std::vector<Vec3> rest(f.end() - 1000, f.end());
    EXPECT_LT(1000 * CalcNoise(rest, 0.001), 2);
    EXPECT_EQ(CountToggles(across, 0.001, 0.01).turns_per_s, 0);
  }
}

TEST(HardCase38, WebOfOneVoxelHoldsAStoppedSawAndIsCutWithoutAKick) {
  Verdict verdict("holds");
  // Cuts from above and from below with a stiff coupling, until one voxel is left between the cuts.
  CoupledParams stiff = test::DiscParams();
  stiff.coupling.stiffness_N_per_mm = 1000;
  stiff.coupling.max_force_N = 1e4;
  const Bone block = test::MakeBox(Pose{}, {26, 4, 6}, kThinWallVoxel);
  CoupledSimulation cutting(block, stiff, DiscPose(Pose{}, {0, 0, 3 + kR + 0.1}));
  for (const double side : {1.0, -1.0}) {
    cutting.SetDown(DiscPose(Pose{}, {0, 0, side * (3 + kR + 0.1)}));
    for (int i = 0; i <= 2000; ++i) {
      const double z = 3 + kR + 0.1 - (3.1 - 0.5 * kThinWallVoxel) * std::min(1.0, i / 1500.0);
      cutting.Tick(Handle(DiscPose(Pose{}, {0, 0, side * z})));
    }
  }
  EXPECT_LT(cutting.UpdateBone().SignedDistance({0, 0, 0}), 0);
  // Cuts again from above, with a soft coupling.
  const double start_z = kR + 0.5 * kThinWallVoxel + 0.3;
  CoupledSimulation simulation(cutting.UpdateBone(), test::DiscParams(), DiscPose(Pose{}, {0, 0, start_z}));
  PushingHand hand(simulation, DiscPose(Pose{}, {0, 0, start_z}));
  CoupledOutput out;
  std::vector<Vec3> f;
  double z_from = 0;
  for (int i = 0; i < 1500; ++i) {
    out = hand.Push({0, 0, -5}, 0);
    if (i == 500) z_from = out.X_WT.p_AB.z;
    if (i > 500) f.push_back(out.f_H_W_N);
  }
  verdict.AtMost("resting with 5 N: further motion", z_from - out.X_WT.p_AB.z, 1e-3, "mm");
  verdict.AtMost("resting: C1", 1000 * CalcNoise(f, 0.001), 1, "mN");
  EXPECT_NEAR(out.X_WT.p_AB.z, kR + 0.5 * kThinWallVoxel, 0.1);
  // With the spindle on, a handle moves the saw down at 2 mm/s. It breaks through, and no force pushes it forward.
  double max_N = 0;
  double kick_N = 0;
  double before_N = 0;
  double drop_N = 0;
  const double z_0 = out.X_WT.p_AB.z;
  for (int i = 0; i < 1500; ++i) {
    const double z = z_0 - 0.002 * i;
    out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, z})));
    max_N = std::max(max_N, out.f_H_W_N.z);
    kick_N = std::max(kick_N, -out.f_H_W_N.z);
    if (i > 0) drop_N = std::max(drop_N, before_N - out.f_H_W_N.z);
    before_N = out.f_H_W_N.z;
  }
  EXPECT_GT(max_N, 0.05);
  EXPECT_GT(cutting.UpdateBone().CalcVolume() - simulation.UpdateBone().CalcVolume(), 0.1);
  verdict.AtMost("cutting through at 2 mm/s: kick along the feed", kick_N, 0.01 * max_N, "N");
  verdict.AtMost("largest drop of the force in a tick", drop_N, max_N, "N");
}

TEST(Extremes, SingleVoxelsInTheWayOfAPlungeAreHardlyFelt) {
  // The dust above the block consists of balls of a voxel's volume, one millimetre apart.
  const auto dust = [](const Vec3& p) {
    const Vec3 q(std::clamp(std::round(p.x), -10.0, 10.0), std::clamp(std::round(p.y), -2.0, 2.0),
                 std::clamp(std::round(p.z), 7.0, 11.0));
    return glm::length(p - q) - 0.125;
  };
  double max_in_dust_N = 0;
  std::vector<Vec3> f[2];
  double removed[2] = {0, 0};
  for (const int dusty : {0, 1}) {
    SolidField field;
    field.value = [&, dusty](const Vec3& p) {
      const double block = test::BoxDistance(p, {13, 3, 5});
      return dusty ? std::min(block, dust(p)) : block;
    };
    field.classify = ClassifyByDistance(field.value);
    field.region = [](const Vec3&) { return 24; };
    const Bone bone =
        MakeBone(field, Box3{{-15, -5, -7}, {15, 5, 13}}, {kThinWallVoxel, kThinWallVoxel, {}}, test::OneRegionTable());
    const double from = 11.5 + kR;
    CoupledParams params = test::DiscParams();
    params.law = ForceLaw("hertz_chip");
    CoupledSimulation simulation(bone, params, DiscPose(Pose{}, {0, 0, from}));
    for (int i = 0; i < 2600; ++i) {
      const CoupledOutput out = simulation.Tick(Handle(DiscPose(Pose{}, {0, 0, from - 0.004 * i})));
      f[dusty].push_back(out.f_H_W_N);
      removed[dusty] += out.removed_mm3;
      if (dusty && out.X_WT.p_AB.z > 5.2 + kR) max_in_dust_N = std::max(max_in_dust_N, glm::length(out.f_H_W_N));
      ASSERT_EQ(out.status & (kCoupledIterationsUsedUp | kCoupledForceLimited), 0u) << i;
    }
  }
  EXPECT_GT(removed[1], removed[0] + 0.1);  // there was dust
  // One voxel of bone under the rim engages at most one tooth, which is a tenth of the feed force on an arc of ten
  // teeth.
  const double in_bone_N = f[0].back().z;
  EXPECT_GT(in_bone_N, 0.5);
  EXPECT_LT(max_in_dust_N, 0.5 * in_bone_N);
  // In the bone the dust has no effect.
  EXPECT_NEAR(f[1].back().z / f[0].back().z, 1, 0.02);
  // Each grain is in contact for less than a tenth of a second, with steps of at most a tenth of the force in bone.
  double worst_N = 0;
  for (std::size_t i = 1; i < f[1].size(); ++i) worst_N = std::max(worst_N, glm::length(f[1][i] - f[1][i - 1]));
  EXPECT_LT(worst_N, 0.1 * in_bone_N);
}

}  // namespace
}  // namespace kerf
