// CT numbers in a bone and the modulus computed from them, compared with closed forms.
#include "bone/grid/ct_modulus.h"

#include <gtest/gtest.h>

#include <random>

#include "kerf/error.h"
#include "support/solids.h"

namespace kerf {
namespace {

/// With rho = HU / 1000 from 100 to 3000 HU, and E = 1000 rho MPa from 0.1 to 2 g/cm3, E = HU, clamped to 100 to 2000
/// MPa.
CtLaw LinearLaw() {
  CtLaw law;
  law.name = "linear";
  law.tissue = "test";
  law.density = "qct";
  law.calibration = {{0, 0}, {3000, 3}};
  law.bands = {{0.1, 2, 0, 1000, 1}};
  law.tag = 'D';
  law.source = "test";
  return law;
}

/// Makes a box of 12 x 8 x 6 mm: cancellous bone (32, nu 0.4) below z = 0.05, cortical bone (24) above.
Bone MakeTwoTissues(double voxel_mm = 0.2) {
  SolidField field;
  field.value = [](const Vec3& p) { return test::BoxDistance(p, Vec3(6, 4, 3)); };
  field.classify = ClassifyByDistance(field.value);
  field.region = [](const Vec3& p) { return p.z < 0.05 ? 32 : 24; };
  MaterialTable table = test::OneRegionTable(24, 19300, 0.28);
  table.Add({32, "cancellous", Tissue::kCancellous, 1370, 0.4, true, "test"});
  return MakeBone(field, Box3{Vec3(-8, -6, -5), Vec3(8, 6, 5)}, {voxel_mm, voxel_mm, {}}, table);
}

double Ramp(const Vec3& p) {
  return 1000 + 80 * p.x - 30 * p.y + 20 * p.z;
}

TEST(CtModulus, FollowsALinearRampInCancellousBoneAndTheTableInCortex) {
  Bone bone = MakeTwoTissues();
  SetHu(bone, Ramp, 0.7);
  EXPECT_EQ(bone.hu_voxel_mm(), 0.7);
  const CtModulusReport report = UseCtModulus(bone, LinearLaw(), false);
  std::mt19937 random(3);
  const auto draw = [&random](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  for (int i = 0; i < 500; ++i) {
    // A trilinear function is interpolated exactly, up to the surface itself; the grid stores seven digits.
    const Vec3 in_cancellous(draw(-6, 6), draw(-4, 4), draw(-3, -0.25));
    EXPECT_NEAR(bone.ModulusAt(in_cancellous), Ramp(in_cancellous), 1e-3);
    EXPECT_NEAR(bone.PoissonRatioAt(in_cancellous), 0.4, 1e-12);
    const Vec3 in_cortex(draw(-6, 6), draw(-4, 4), draw(0.25, 3));
    EXPECT_NEAR(bone.ModulusAt(in_cortex), 19300, 1e-6);
  }
  EXPECT_EQ(report.fraction_below + report.fraction_above, 0);
  // About 840 of the 0.343 mm3 voxels have their centre inside the cancellous 12 x 8 x 3 mm.
  EXPECT_NEAR(static_cast<double>(report.voxels), 12 * 8 * 3 / 0.343, 100);
  EXPECT_NEAR(report.E_p50_MPa, 1000 - 30, 40);  // at the middle, z = -1.5
  EXPECT_GE(report.E_min_MPa, 1000 - 480 - 120 - 60);
  EXPECT_LE(report.E_max_MPa, 1000 + 480 + 120 + 1);
}

TEST(CtModulus, AllRegionsIncludeTheCortex) {
  Bone bone = MakeTwoTissues();
  SetHu(bone, Ramp, 0.7);
  UseCtModulus(bone, LinearLaw(), true);
  EXPECT_NEAR(bone.ModulusAt({1, 1, 2}), Ramp({1, 1, 2}), 1e-3);
  EXPECT_NEAR(bone.PoissonRatioAt({1, 1, 2}), 0.28, 1e-12);
}

TEST(CtModulus, ValuesOutsideTheLawsRangeAreClampedAndCounted) {
  Bone bone = MakeTwoTissues();
  // Along x, a quarter of the box is below the law's 100 HU and a quarter above its 2000 HU.
  SetHu(
      bone, [](const Vec3& p) { return p.x < -3  ? -50
                                       : p.x > 3 ? 2500
                                                 : 1000; }, 0.25);
  const CtModulusReport report = UseCtModulus(bone, LinearLaw(), false);
  // The tolerance is one layer of 0.25 mm voxels in 12 mm, 2 %.
  EXPECT_NEAR(report.fraction_below, 0.25, 0.021);
  EXPECT_NEAR(report.fraction_above, 0.25, 0.021);
  EXPECT_NEAR(bone.ModulusAt({-5, 0, -1}), 100, 1e-4);
  EXPECT_NEAR(bone.ModulusAt({5, 0, -1}), 2000, 1e-3);
  EXPECT_NEAR(report.E_min_MPa, 100, 1e-4);
  EXPECT_NEAR(report.E_max_MPa, 2000, 1e-3);
}

TEST(CtModulus, CoversEveryPointOfTheBoneForAnyVoxelSize) {
  for (const double hu_voxel : {0.1, 0.45, 1.0, 3.0}) {
    Bone bone = MakeTwoTissues(0.4);
    SetHu(
        bone, [](const Vec3&) { return 777.0; }, hu_voxel);
    UseCtModulus(bone, LinearLaw(), true);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int i = 0; i < 2000; ++i) {
      Vec3 p = Vec3(6, 4, 3) * Vec3(unit(random), unit(random), unit(random));
      p[i % 3] = std::copysign(Vec3(6, 4, 3)[i % 3], p[i % 3]);  // on the surface
      ASSERT_NEAR(bone.ModulusAt(p), 777, 1e-3) << hu_voxel;
    }
  }
}

TEST(CtModulus, WithoutCtNumbersThereIsNoGridAndNoMemory) {
  Bone bone = MakeTwoTissues();
  const std::uint64_t plain = bone.CalcMemoryBytes();
  const std::uint64_t hash = bone.CalcHash();
  EXPECT_FALSE(bone.has_hu());
  EXPECT_EQ(bone.hu_voxel_mm(), 0);
  EXPECT_EQ(CalcHuRange(bone).voxels, 0u);
  EXPECT_THROW(UseCtModulus(bone, LinearLaw(), false), Error);
  SetHu(bone, Ramp, 0.7);
  const std::uint64_t with_hu = bone.CalcMemoryBytes();
  EXPECT_GT(with_hu, plain);
  // The bone's state is its shape and its regions; CT numbers do not change it.
  EXPECT_EQ(bone.CalcHash(), hash);
  UseCtModulus(bone, LinearLaw(), false);
  EXPECT_GT(bone.CalcMemoryBytes(), with_hu);
  const Bone copy = bone;
  EXPECT_EQ(copy.ModulusAt({1, 1, -1}), bone.ModulusAt({1, 1, -1}));
}

TEST(CtModulus, HuRangeIncludesOnlyVoxelsInTheBone) {
  Bone bone = MakeTwoTissues();
  // Only voxels inside the bone count; those outside have absurd values.
  SetHu(
      bone, [](const Vec3& p) { return test::BoxDistance(p, Vec3(6, 4, 3)) < 0 ? 500 + 10 * p.x : 9999; }, 0.5);
  const HuRange range = CalcHuRange(bone);
  EXPECT_NEAR(range.min, 500 - 10 * 5.5, 5.1);
  EXPECT_NEAR(range.max, 500 + 10 * 5.5, 5.1);
  EXPECT_NEAR(range.mean, 500, 1e-2);
}

TEST(Bone, OverriddenConstantsAreUsed) {
  Bone bone = MakeTwoTissues();
  bone.OverrideMaterials(MakeUniformTable(bone.materials(), 19300, 0.28));
  EXPECT_NEAR(bone.ModulusAt({1, 1, -1}), 19300, 1e-8);
  EXPECT_NEAR(bone.ModulusAt({1, 1, 1}), 19300, 1e-8);
  EXPECT_NEAR(bone.PoissonRatioAt({1, 1, -1}), 0.28, 1e-12);
}

}  // namespace
}  // namespace kerf
