// Hard case 25: the end of the grid, tools partly or entirely outside it, and an empty bone. Outside the grid there is
// air.
#include "bone/grid/grids.h"
#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "kerf/error.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::Handle;
using test::Sawing;

/// Returns a block that is truncated at x = 0 by the end of the grid: solid bone becomes air within a voxel.
Bone CutOff(double h) {
  Bone bone = test::MakeBox(Pose{}, {24, 2, 8}, h);
  auto& tree = GridsOf(bone).phi->tree();
  std::vector<openvdb::Coord> beyond;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    if (leaf->origin().x() >= 0) beyond.push_back(leaf->origin());
  }
  for (const openvdb::Coord& at : beyond) tree.addTile(1, at, tree.background(), false);
  for (int x = 0; x < 80; x += 8) {
    for (int y = -8; y <= 8; y += 8) {
      for (int z = -40; z <= 40; z += 8) {
        if (tree.getValue({x, y, z}) < 0) tree.addTile(1, {x, y, z}, tree.background(), false);
      }
    }
  }
  return bone;
}

TEST(HardCase25, ForceIsContinuousOutOfTheBlockAndBack) {
  test::Verdict verdict("holds");
  double max_step = 0;
  double stopped_step = 0;
  double max_N = 0;
  double max_air_N = 0;
  for (const double h : {0.2, 0.4}) {
    for (const double depth : {0.3, 2.0}) {
      for (const double rpm : {7500.0, 0.0}) {
        const double z = 4 + kR - depth;
        const double x = 5 + std::sqrt(kR * kR - (kR - depth) * (kR - depth)) + 1;
        // A stopped disc would hit the block's side, so it starts on top of the block.
        Sawing saw(test::MakeBox(Pose{}, {10, 2, 8}, h), DiscParams(),
                   DiscPose(Pose{}, rpm == 0 ? Vec3(0, 0, 4 + kR + 0.2) : Vec3(-x, 0, z)));
        if (rpm == 0) saw.Move(DiscPose(Pose{}, {0, 0, z}), 300, rpm);
        Vec3 f_before = saw.out.f_H_W_N;
        // The disc is first entirely outside, then partly, then entirely inside, and leaves at the other end.
        saw.Move(DiscPose(Pose{}, {x, 0, z}), static_cast<int>(2 * x / 0.005), rpm, [&](const CoupledOutput& out) {
          const double f = glm::length(out.f_H_W_N);
          double& step = rpm == 0 ? stopped_step : max_step;
          step = std::max(step, glm::length(out.f_H_W_N - f_before) / (0.07 * std::max(f, 0.5)));
          max_N = std::max(max_N, f);
          f_before = out.f_H_W_N;
          const double over = std::abs(saw.X_WH.p_AB.x) - (x - 0.5);
          if (over > 0) max_air_N = std::max(max_air_N, f);
        });
        EXPECT_LT(glm::length(saw.out.f_H_W_N), 1e-9) << h << " " << depth;
        saw.invariants.CheckBone();
      }
    }
  }
  EXPECT_GT(max_N, 0.3);
  verdict.AtMost("largest force step in a tick in JND", max_step, 2);
  verdict.AtMost("largest force step in a tick in JND, spindle stopped, over a sharp corner", stopped_step, 2);
  verdict.AtMost("force half a millimetre outside the block", max_air_N, 1e-9, "N");
}

TEST(HardCase25, BeyondTheEndOfTheGridIsAir) {
  test::Verdict verdict("holds: outside the grid is air");
  const double h = 0.2;
  const Bone bone = CutOff(h);
  EXPECT_LT(bone.SignedDistance({-0.5, 0, 0}), 0);
  EXPECT_GT(bone.SignedDistance({0.5, 0, 0}), 0);
  double max_N = 0;
  for (const double rpm : {7500.0, 0.0}) {
    // The disc moves along the floor of the cut from the bone across the grid's end and back, and is lowered at the
    // grid's end.
    Sawing saw(bone, DiscParams(), DiscPose(Pose{}, {-6, 0, 4 + kR + 0.1}));
    const auto look = [&](const CoupledOutput& out) { max_N = std::max(max_N, glm::length(out.f_H_W_N)); };
    const double down = rpm == 0 ? -0.5 : 0.5;
    saw.Move(DiscPose(Pose{}, {-6, 0, 4 + kR - std::abs(down)}), 200, rpm, look);
    saw.Move(DiscPose(Pose{}, {14, 0, 4 + kR - std::abs(down)}), 1500, rpm, look);
    saw.Move(DiscPose(Pose{}, {0, 0, 4 + kR + 2}), 1000, rpm, look);
    saw.Move(DiscPose(Pose{}, {0, 0, 4 + kR - 2}), 1000, rpm, look);
    saw.invariants.CheckBone();
  }
  // The bound is the hand's motion times the spring's stiffness, which is the largest stiffness in the system.
  verdict.AtMost("largest force", max_N, 2.5, "N");
}

TEST(HardCase25, EmptyBoneIsAir) {
  test::Verdict verdict("holds");
  for (const double rpm : {7500.0, 0.0}) {
    CoupledSimulation simulation(Bone(), DiscParams(), Pose{});
    for (int i = 0; i < 100; ++i) {
      Pose X = DiscPose(Pose{}, {0.1 * i, -0.2 * i, 0.3 * i - 5});
      const CoupledOutput out = simulation.Tick(Handle(X, rpm));
      ASSERT_EQ(out.f_H_W_N, Vec3(0));
      ASSERT_EQ(out.tau_H_W_Nmm, Vec3(0));
      ASSERT_EQ(out.X_WT.p_AB, X.p_AB);
      ASSERT_EQ(out.removed_mm3, 0);
    }
    EXPECT_TRUE(simulation.UpdateBone().empty());
    Simulation path(Bone(), {}, Pose{});
    const TickOutput out = path.Tick({DiscPose(Pose{}, {1, 2, 3}), 0.001, rpm});
    EXPECT_EQ(out.f_T_W_N, Vec3(0));
    EXPECT_EQ(out.removed_mm3, 0);
  }
  SolidField nothing = test::SphereField(Vec3(0), -1);
  EXPECT_THROW(MakeBone(nothing, Box3{Vec3(-1), Vec3(1)}, {0.2, 0.2, {}}, test::OneRegionTable()), Error);
}

TEST(HardCase25, CompletelyRemovedBoneIsAir) {
  test::Verdict verdict("holds");
  // A crumb smaller than the disc's rim is removed completely.
  const Bone bone = test::MakeSphere(Vec3(0.02, 0.01, 0.03), 0.1, 0.1);
  const double before_mm3 = bone.CalcVolume();
  CoupledParams params = DiscParams();
  Sawing saw(bone, params, DiscPose(Pose{}, {0, 0, kR + 0.5}));
  saw.Move(DiscPose(Pose{}, {0, 0, kR - 0.6}), 1000);
  saw.Move(DiscPose(Pose{}, {0, 0, kR + 0.5}), 300);
  saw.invariants.CheckBone();
  EXPECT_TRUE(saw.simulation.UpdateBone().empty());
  EXPECT_EQ(saw.simulation.UpdateBone().CalcVolume(), 0);
  double gone_mm3 = 0;
  for (const double mm3 : saw.simulation.CalcRemovedByRegion()) gone_mm3 += mm3;
  verdict.AtMost("relative volume unaccounted for", std::abs(gone_mm3 / before_mm3 - 1), 1e-9);
  for (int i = 0; i < 5; ++i) saw.To(DiscPose(Pose{}, {0, 0, kR - 1}), 0);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(saw.To(DiscPose(Pose{}, {0, 0.01 * i, kR - 1}), 0).f_H_W_N, Vec3(0));
}

}  // namespace
}  // namespace kerf
