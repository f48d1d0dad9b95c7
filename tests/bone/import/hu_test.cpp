// The CT numbers that an import keeps are those of the CT.
#include <gmock/gmock.h>

#include <glm/gtc/quaternion.hpp>
#include <random>

#include "bone/grid/ct_modulus.h"
#include "bone/import/import.h"
#include "bone/vdb/bonefile.h"
#include "ct_files.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;

const Vec3 kCentre(3.2, -41.6, 77.4);
constexpr double kRadius = 12;

double Ramp(const Vec3& p) {
  return 1000 + 20 * (p.x - kCentre.x) - 15 * (p.y - kCentre.y) + 8 * (p.z - kCentre.z);
}

/// A ball with a linear ramp of CT numbers, surrounded by air.
Volume MakeRampCt(const Vec3& spacing_mm, const glm::dmat3& axes_W) {
  std::array<int, 3> size{};
  Vec3 middle;
  for (int a = 0; a < 3; ++a) {
    size[a] = static_cast<int>(std::ceil(40 / spacing_mm[a]));
    middle[a] = 0.5 * (size[a] - 1) * spacing_mm[a] + 0.3;
  }
  Volume ct = test::MakeCt(size, spacing_mm, kCentre - axes_W * middle, axes_W, test::Ball(kCentre, kRadius));
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const Vec3 p_W = ct.WorldFromVoxel({i, j, k});
        const double HU = glm::length(p_W - kCentre) < kRadius ? Ramp(p_W) : -1000;
        ct.hu[ct.Index(i, j, k)] = static_cast<std::int16_t>(std::lround(HU));
      }
    }
  }
  return ct;
}

ImportOptions KeepHu() {
  ImportOptions options;
  options.voxel_mm = 0.4;
  options.isolate.isolate = false;
  options.isolate.smallest_piece_mm3 = 0;
  options.keep_hu = true;
  return options;
}

/// E = HU MPa.
CtLaw Identity() {
  CtLaw law;
  law.name = "identity";
  law.density = "qct";
  law.calibration = {{0, 0}, {3000, 3}};
  law.bands = {{0.001, 3, 0, 1000, 1}};
  law.source = "test";
  return law;
}

TEST(KeptHu, MatchTheCtForAnyLattice) {
  const glm::dmat3 oblique = glm::mat3_cast(glm::angleAxis(0.6, glm::normalize(Vec3(1, -1, 2))));
  for (const auto& [spacing, axes] : {std::pair{Vec3(1, 1, 1), glm::dmat3(1)}, {Vec3(0.5, 0.7, 1.5), oblique}}) {
    const Folder folder;
    test::WriteNrrd(MakeRampCt(spacing, axes), folder.file("ct.nrrd"));
    ImportResult result = Import(folder.file("ct.nrrd"), KeepHu());
    EXPECT_EQ(result.report.hu_voxel_mm, std::min({spacing.x, spacing.y, spacing.z}));
    EXPECT_EQ(result.bone.hu_voxel_mm(), result.report.hu_voxel_mm);
    UseCtModulus(result.bone, Identity(), true);
    std::mt19937 random(2);
    std::uniform_real_distribution<double> unit(-1, 1);
    // All voxels of both lattices around the point must lie in the ball, so the point is deeper than the sum of both
    // voxel diagonals.
    const double inner = kRadius - glm::length(spacing) - std::sqrt(3.0) * result.report.hu_voxel_mm;
    int checked = 0;
    while (checked < 300) {
      const Vec3 offset = inner * Vec3(unit(random), unit(random), unit(random));
      if (glm::length(offset) > inner) continue;
      // The function is linear, except for rounding to integers in the CT.
      EXPECT_NEAR(result.bone.ModulusAt(kCentre + offset), Ramp(kCentre + offset), 0.51);
      ++checked;
    }
    // Near the surface the values are blended with air: they are close to the iso value there, not to the ramp.
    double at_surface = 0;
    double ramp = 0;
    for (int n = 0; n < 300; ++n) {
      const Vec3 p_W = kCentre + (kRadius - 0.2) * glm::normalize(Vec3(unit(random), unit(random), unit(random)));
      at_surface += result.bone.ModulusAt(p_W) / 300;
      ramp += Ramp(p_W) / 300;
    }
    EXPECT_LT(at_surface, 0.6 * ramp);
  }
}

TEST(KeptHu, AreKeptOnlyOnRequestAndSurviveAFileRoundTrip) {
  const Folder folder;
  test::WriteNrrd(MakeRampCt({1, 1, 1}, glm::dmat3(1)), folder.file("ct.nrrd"));
  ImportOptions options = KeepHu();
  options.hu_voxel_mm = 0.8;
  const ImportResult kept = Import(folder.file("ct.nrrd"), options);
  EXPECT_EQ(kept.report.hu_voxel_mm, 0.8);
  EXPECT_NEAR(kept.report.hu.max, 1000 + glm::length(Vec3(20, -15, 8)) * kRadius, 35);
  EXPECT_EQ(kept.bone.notes().at("import_hu_voxel_mm"), "0.8");
  options.keep_hu = false;
  options.hu_voxel_mm = 0;
  const ImportResult plain = Import(folder.file("ct.nrrd"), options);
  EXPECT_FALSE(plain.bone.has_hu());
  EXPECT_EQ(plain.report.hu_voxel_mm, 0);
  EXPECT_EQ(plain.bone.notes().count("import_hu_voxel_mm"), 0u);
  EXPECT_EQ(plain.bone.CalcHash(), kept.bone.CalcHash());
  EXPECT_LT(plain.bone.CalcMemoryBytes(), kept.bone.CalcMemoryBytes());
  WriteBone(kept.bone, folder.file("b.vdb"));
  const HuRange read = CalcHuRange(ReadBone(folder.file("b.vdb"), {.hu = true}));
  EXPECT_EQ(read.min, kept.report.hu.min);
  EXPECT_EQ(read.mean, kept.report.hu.mean);
  EXPECT_EQ(read.max, kept.report.hu.max);
}

TEST(KeptHu, SurfacesAndVoxelsOutOfRangeAreRefused) {
  ImportOptions options = KeepHu();
  EXPECT_EQ(MessageOf([&] { Import("jaw.stl", options); }), "jaw.stl: a surface has no CT numbers to keep");
  options.hu_voxel_mm = 7;
  EXPECT_EQ(MessageOf([&] { Import("ct.nrrd", options); }),
            "import: hu_voxel_mm = 7 is above 5; valid range 0.1 to 5 mm, or 0");
}

}  // namespace
}  // namespace kerf
