// The bone in the blade's path: the paper's bands, a layered block, and the law for both.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bone/material/region_table.h"
#include "bone/models/block.h"
#include "cut/slab_sim/resistance.h"
#include "kerf/error.h"
#include "slab_setup.h"

namespace kerf {
namespace {

TEST(PaperProfile, HasTheDepthsOfTable2InTheMiddlesOfItsBands) {
  const SlabProfile profile = MakePaperProfile(DefaultMandibleTable(), 7);
  ASSERT_EQ(profile.layers.size(), 4u);
  const int regions[] = {24, 21, 13, 6};
  const double depths_mm[] = {3.75, 12.5, 18.75, 26.25};
  const double E_GPa[] = {19.3, 20.5, 19.3, 17.3};
  for (std::size_t i = 0; i < 4; ++i) {
    const double bottom = i + 1 < 4 ? profile.layers[i + 1].top_mm : profile.end_mm;
    EXPECT_EQ(0.5 * (profile.layers[i].top_mm + bottom), depths_mm[i]);
    EXPECT_EQ(profile.layers[i].region, regions[i]);
    EXPECT_EQ(profile.layers[i].E_MPa, 1000 * E_GPa[i]);
    EXPECT_EQ(profile.Find(depths_mm[i]), &profile.layers[i]);
  }
  EXPECT_EQ(profile.entry_mm, 7);
  EXPECT_EQ(profile.Find(-0.001), nullptr);
  EXPECT_EQ(profile.Find(32.501), nullptr);
  EXPECT_EQ(profile.Find(std::nan("")), nullptr);
  MaterialTable without;
  EXPECT_THROW(MakePaperProfile(without, 0), Error);
}

TEST(BoneProfile, LayeredBlockHasItsLayersAtTheirDepthsInAnyPose) {
  BlockParams block;
  block.size_mm = {12, 8, 10};
  block.voxel_mm = 0.2;
  block.layers = {{2.5, 24}, {4, 32}, {3.5, 6}};
  for (const bool turned : {false, true}) {
    if (turned) block.X_WB = {glm::normalize(Quat(0.8, 0.3, -0.4, 0.2)), Vec3(3, -4, 5)};
    const Bone bone = MakeBlock(block, DefaultMandibleTable());
    // The block's frame: z points out of its top face, whose middle is the origin.
    const CutPlane plane{block.X_WB.Point({0, 0, 8}), block.X_WB.Vector({0, 1, 0})};
    const Vec3 down_W = block.X_WB.Vector({0, 0, -1});
    const SlabProfile profile = MakeBoneProfile(bone, plane, 0.25, down_W, 11);
    // The profile is sampled every quarter of a voxel; the surface is more accurate than that, and borders of regions
    // are known to half a voxel's diagonal.
    EXPECT_NEAR(profile.entry_mm, glm::dot(block.X_WB.p_AB, down_W), 0.1);
    EXPECT_NEAR(profile.end_mm, 10, 0.15);
    // Samples are on columns one voxel apart: the area is accurate to one voxel of width and two of height.
    EXPECT_NEAR(profile.slice_mm3, 12 * 10 * 0.25, 0.03 * 30);
    for (const auto& [depth, region, E_GPa] :
         {std::tuple(1.25, 24, 19.3), std::tuple(4.5, 32, 0.0), std::tuple(8.25, 6, 17.3)}) {
      const SlabProfile::Layer* layer = profile.Find(depth);
      ASSERT_NE(layer, nullptr);
      EXPECT_EQ(layer->region, region);
      if (E_GPa > 0) {
        EXPECT_NEAR(layer->E_MPa, 1000 * E_GPa, 1e-6);
      }
    }
    for (const double border : {2.5, 6.5}) {
      const SlabProfile::Layer* above = profile.Find(border - 0.2);
      const SlabProfile::Layer* below = profile.Find(border + 0.2);
      ASSERT_TRUE(above != nullptr && below != nullptr);
      EXPECT_NE(above->region, below->region) << border;
    }
  }
}

TEST(BoneProfile, IncludesOnlyBoneThatTheDiscCanReach) {
  BlockParams block;
  block.size_mm = {40, 8, 6};
  block.voxel_mm = 0.25;
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  const SlabProfile profile = MakeBoneProfile(bone, {{0, 0, 20}, {0, 1, 0}}, 0.25, {0, 0, -1}, 11);
  EXPECT_NEAR(profile.slice_mm3, 22 * 6 * 0.25, 0.04 * 33);
  EXPECT_THROW(MakeBoneProfile(bone, {{60, 0, 20}, {0, 1, 0}}, 0.25, {0, 0, -1}, 11), Error);
  EXPECT_THROW(MakeBoneProfile(bone, {{0, 9, 20}, {0, 1, 0}}, 0.25, {0, 0, -1}, 11), Error);
}

TEST(BoneProfile, SamplesAcrossTheSlicesThickness) {
  BlockParams block;
  block.size_mm = {12, 8, 6};
  block.voxel_mm = 0.2;
  const Bone bone = MakeBlock(block, DefaultMandibleTable());
  const SlabProfile whole = MakeBoneProfile(bone, {{0, 0, 20}, {0, 1, 0}}, 0.9, {0, 0, -1}, 11);
  // The slice is 0.9 mm thick about y = 3.9. One of its three layers of samples (3.6, 3.9, 4.2) is outside the block,
  // which ends at 4.
  const SlabProfile edge = MakeBoneProfile(bone, {{0, 3.9, 20}, {0, 1, 0}}, 0.9, {0, 0, -1}, 11);
  EXPECT_NEAR(edge.slice_mm3, 2.0 / 3 * whole.slice_mm3, 0.01 * whole.slice_mm3);
}

TEST(SlabResistance, MatchesThePapersTablesAtTheirDepths) {
  // The 24 forces, printed to 5 decimals. tests/cut/paper compares them with the formulas; here regions 24 and 6 are
  // computed by the complete slab law.
  const double depths[] = {1.1, 2.2, 3.3, 4.4, 5.5, 6.6};
  const double region24[] = {0.05541, 0.44325, 0.44325, 1.49595, 1.49595, 3.54596};
  SlabParams params;
  const SlabResistance law(MakePaperProfile(DefaultMandibleTable(), 0), params);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(law.At(depths[i]).force_N, region24[i], 2e-4 * region24[i]);
  EXPECT_EQ(law.At(25).teeth, 8);
  EXPECT_NEAR(law.At(7).force_N, 64 * 0.0554062, 1e-4 * 3.5);
  EXPECT_EQ(law.At(-0.1).force_N, 0);
  EXPECT_EQ(law.At(33).force_N, 0);
}

TEST(SlabResistance, CorrectedIsTheSumOverTheArcToothByTooth) {
  SlabParams params;
  params.reading = PaperReading::kCorrected;
  const SlabProfile profile = MakePaperProfile(DefaultMandibleTable(), 0);
  const SlabResistance law(profile, params);
  const double R = params.saw.radius_mm();
  for (const double depth : {0.5, 1.1, 6.6, 9.0, 18.0, 21.9, 25.0, 32.0, 32.5}) {
    // Compared with brute force: 200,000 points on half of the rim, from its lowest point up.
    double force = 0;
    constexpr int kPoints = 200000;
    for (int i = 0; i < kPoints; ++i) {
      const double theta = (i + 0.5) * std::numbers::pi / kPoints;
      const double at = depth - R * (1 - std::cos(theta));
      const SlabProfile::Layer* layer = profile.Find(at);
      if (layer == nullptr) continue;
      force += CalcPaperToothForce(params.saw, 0.01, layer->E_MPa, layer->nu) * R * std::numbers::pi / kPoints /
               params.saw.pitch_mm();
    }
    EXPECT_NEAR(law.At(depth).force_N, force, 1e-3 * force) << depth;
  }
}

TEST(SlabResistance, DoublesWithBothModuliAndGrowsEightfoldWithTheFractionOfThePitch) {
  for (const PaperReading reading : {PaperReading::kAsComputed, PaperReading::kCorrected}) {
    SlabParams params;
    params.reading = reading;
    SlabParams stiff = params;
    stiff.saw.E_MPa *= 2;
    SlabParams wide = params;
    wide.contact_share_of_pitch *= 2;
    const SlabResistance law(test::UniformProfile(10000, 0.3, 20.013), params);
    const SlabResistance doubled(test::UniformProfile(20000, 0.3, 20), stiff);
    const SlabResistance eightfold(test::UniformProfile(10000, 0.3, 20), wide);
    for (double depth = 0.5; depth < 20; depth += 0.37) {
      EXPECT_NEAR(law.At(depth).E_MPa, 10000, 1e-9);
      EXPECT_NEAR(doubled.At(depth).force_N, 2 * law.At(depth).force_N, 1e-12);
      EXPECT_NEAR(eightfold.At(depth).force_N, 8 * law.At(depth).force_N, 1e-11);
    }
  }
}

}  // namespace
}  // namespace kerf
