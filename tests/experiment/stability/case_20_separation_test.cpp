// Hard case 20: the bone separates into pieces. Their number is exact, no volume is lost, and the force has no jump.
#include <numeric>

#include "experiment/stability/in_kerf.h"
#include "experiment/stability/verdict.h"
#include "kerf/surface.h"
#include "loop/haptics/held_saw.h"
#include "support/saw.h"

namespace kerf {
namespace {

using test::DiscParams;
using test::DiscPose;
using test::InKerf;
using test::Sawing;

double SumOfVolumes(const Pieces& pieces) {
  return std::accumulate(pieces.pieces.begin(), pieces.pieces.end(), 0.0,
                         [](double sum, const Bone& piece) { return sum + piece.CalcVolume(); });
}

/// Returns two blocks joined by `bridges` bars, each a single voxel thick, across the plane y = 0 at height z = 0.
Bone Bridged(double h, int bridges) {
  const auto value = [h, bridges](const Vec3& p) {
    const auto index = [h](double x) { return static_cast<int>(std::floor(x / h + 0.5)); };
    const double blocks =
        std::min(test::BoxDistance(p - Vec3(0, 2, 0), {4, 1, 1}), test::BoxDistance(p + Vec3(0, 2, 0), {4, 1, 1}));
    for (int n = 0; n < bridges; ++n) {
      if (index(p.x) == 4 * n && index(p.z) == 0 && std::abs(p.y) < 2) return std::min(blocks, -0.5 * h);
    }
    return blocks;
  };
  SolidField field;
  field.value = value;
  field.classify = [](const Vec3&, double) { return BlockClass::kMixed; };
  field.region = [](const Vec3&) { return 24; };
  return MakeBone(field, Box3{{-4, -3, -1}, {4, 3, 1}}.Grown(6 * h), {h, h, {}}, test::OneRegionTable());
}

TEST(HardCase20, PiecesAreCountedExactlyToTheLastVoxel) {
  test::Verdict verdict(
      "holds: two parts are one piece as long as one voxel joins them, and two pieces from the tick that removes it");
  const double h = 0.2;
  const Bone bone = Bridged(h, 3);
  ASSERT_EQ(SplitPieces(bone).pieces.size(), 1u);
  const double before_mm3 = bone.CalcVolume();
  // In a stroke along x, the rim passes the bridges one after another.
  const double z = kR - 0.5;
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = 100;
  Sawing saw(bone, params, DiscPose(Pose{}, {-5, 0, z}));
  int intact_before = 3;
  int wrong = 0;
  int looks = 0;
  for (int i = 1; i <= 500; ++i) {
    saw.To(DiscPose(Pose{}, {-5 + 0.01 * i, 0, z}));
    int intact = 0;
    for (int n = 0; n < 3; ++n) intact += saw.simulation.UpdateBone().SignedDistance({4 * n * h, 0, 0}) < 0 ? 1 : 0;
    if (intact != intact_before || i % 50 == 0) {
      const Pieces pieces = SplitPieces(saw.simulation.UpdateBone());
      wrong += pieces.pieces.size() == (intact > 0 ? 1u : 2u) && pieces.dust_count == 0 ? 0 : 1;
      ++looks;
    }
    intact_before = intact;
  }
  EXPECT_EQ(intact_before, 0);
  EXPECT_GE(looks, 12);
  saw.invariants.CheckBone();
  const Bone& after = saw.simulation.UpdateBone();
  const auto removed = saw.simulation.CalcRemovedByRegion();
  const double gone_mm3 = std::accumulate(removed.begin(), removed.end(), 0.0);
  verdict.Equal("wrong piece counts", wrong, 0);
  verdict.AtMost("volume unaccounted for relative to the initial volume",
                 std::abs(after.CalcVolume() + gone_mm3 - before_mm3) / before_mm3, 1e-6);
  verdict.AtMost("relative difference between the pieces' volumes and the bone's",
                 std::abs(SumOfVolumes(SplitPieces(after)) / after.CalcVolume() - 1), 1e-6);
}

/// Forces on a hand at a steady feed while a bar 4 mm high is cut through.
struct Through {
  double max_N = 0;
  double max_step_N = 0;  // between ticks, while the bar separates
  double max_back_N = 0;  // that draws the hand further into the cut
};
Through CutThrough(double feed_mm_per_s, double stiffness_N_per_mm) {
  const Pose start = DiscPose(Pose{}, {0, 0, 2 + kR + 0.1});
  CoupledParams params = DiscParams();
  params.coupling.stiffness_N_per_mm = stiffness_N_per_mm;
  params.coupling.max_force_N = 1000;
  Sawing saw(test::MakeBox(Pose{}, {8, 6, 4}, 0.2), params, start);
  Through through;
  Vec3 f_before(0);
  const double depth_mm = 7;
  for (int i = 1; i <= 20000 && saw.out.X_WT.p_AB.z > -2 + kR - 1.5; ++i) {
    saw.To(DiscPose(Pose{}, {0, 0, start.p_AB.z - std::min(0.001 * feed_mm_per_s * i, depth_mm)}));
    const double f = glm::length(saw.out.f_H_W_N);
    // Once the floor is through, the remaining bone is removed from the middle outwards.
    if (saw.out.X_WT.p_AB.z < -2 + kR) {
      through.max_step_N = std::max(through.max_step_N, glm::length(saw.out.f_H_W_N - f_before));
    }
    through.max_back_N = std::max(through.max_back_N, -saw.out.f_H_W_N.z);
    through.max_N = std::max(through.max_N, f);
    f_before = saw.out.f_H_W_N;
  }
  for (int i = 0; i < 20; ++i) saw.To(saw.X_WH);
  saw.invariants.CheckBone();
  // The bar is cut through: no force is left, and there are two pieces, each with half of the remaining volume.
  EXPECT_LT(glm::length(saw.out.f_H_W_N), 1e-6) << feed_mm_per_s;
  const Pieces pieces = SplitPieces(saw.simulation.UpdateBone());
  EXPECT_EQ(pieces.pieces.size(), 2u) << feed_mm_per_s;
  EXPECT_EQ(pieces.dust_count, 0u) << feed_mm_per_s;
  EXPECT_NEAR(pieces.pieces[0].CalcVolume(), 8 * 4 * (3 - 0.125), 0.01 * 96) << feed_mm_per_s;
  return through;
}

TEST(HardCase20, ABarCutThroughGivesTwoPiecesAndNoBlow) {
  test::Verdict verdict(
      "applies in part: pieces do not move (they stay held in place), and a separation is reported by the effect "
      "`fragments`, not by the tick; a count on request is exact");
  double max_fraction = 0;
  double max_back_N = 0;
  double soft_N = 0;
  for (const double feed : {2.0, 5.0, 20.0}) {
    // A stiff coupling shows the bone's own force. With a spring of 1 N/mm, the last sliver releases the stored energy.
    const Through firm = CutThrough(feed, 1000);
    const Through soft = CutThrough(feed, 1);
    EXPECT_GT(firm.max_N, 0.3) << feed;
    max_fraction = std::max(max_fraction, firm.max_step_N / firm.max_N);
    soft_N = std::max(soft_N, soft.max_step_N);
    max_back_N = std::max({max_back_N, firm.max_back_N, soft.max_back_N});
  }
  verdict.AtMost("stiff coupling: largest force step in a tick during separation relative to the cutting force",
                 max_fraction, 0.1);
  // The bound is the distance of the tool in a tick times the spring's stiffness.
  verdict.AtMost("spring of 1 N/mm: largest force step in a tick during separation", soft_N, 24 * 0.5 * 0.2 * 1.05,
                 "N");
  verdict.AtMost("force that pulls the hand further into the cut", max_back_N, 1e-6, "N");
}

TEST(HardCase20, DeviceForceKeepsItsSlewRateWhenAHandBreaksThrough) {
  test::Verdict verdict(
      "holds, but after the last sliver the tool, which has no mass, moves to the handle within a few ticks; the "
      "force on the device falls at its slew rate");
  test::HeldSawOptions options;
  options.block_mm = {8, 6, 4};
  test::HeldSaw saw(options);
  test::Invariants watch(saw.simulation, saw.start);
  watch.WatchDevice(saw.device.profile());
  IntentionStep push;
  push.seconds = 20;
  push.X_WH = saw.start;
  push.push_W_N = Vec3(0, 0, -8);
  push.yield_s = 0.5;
  saw.device.SetScript(IntentionScript(saw.start, {push}));
  double max_step_N = 0;
  double max_jump_mm = 0;
  double lowest_N = 0;
  Vec3 f_before(0);
  double z_before = saw.start.p_AB.z;
  for (int i = 0; i < 12000; ++i) {
    const HapticTick out = saw.Step();
    watch.Step(out);
    max_step_N = std::max(max_step_N, glm::length(out.force.f_H_W_N - f_before));
    max_jump_mm = std::max(max_jump_mm, z_before - out.coupled.X_WT.p_AB.z);
    lowest_N = std::min(lowest_N, out.force.f_H_W_N.z);
    f_before = out.force.f_H_W_N;
    z_before = out.coupled.X_WT.p_AB.z;
    if (out.coupled.X_WT.p_AB.z < -4 - kR) break;
  }
  watch.CheckBone();
  ASSERT_EQ(SplitPieces(saw.simulation.UpdateBone()).pieces.size(), 2u);
  verdict.AtMost("largest step of the device force", max_step_N, 40 * 0.001 / 0.005, "N");
  verdict.Note("largest motion of the tool in a tick", max_jump_mm, "mm");
  verdict.AtLeast("force into the cut", lowest_N, -1e-6, "N");
}

}  // namespace
}  // namespace kerf
