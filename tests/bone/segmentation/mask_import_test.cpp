// Import of a bone that a segmentation selects.
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <numbers>

#include "base/files/markups.h"
#include "bone/import/image_file.h"
#include "bone/import/import.h"
#include "bone/import/mask_overlay.h"
#include "bone/import/patient_frame.h"
#include "bone/material/region_table.h"
#include "bone/material/segment_regions.h"
#include "bone/segmentation/roles.h"
#include "kerf/import.h"
#include "kerf/surface.h"
#include "label_files.h"
#include "support/jaw_ct.h"
#include "support/message_of.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::Ball;
using test::Folder;
using test::MessageOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// The balls of the tests of Isolate(): radii of 10 and 13 mm, joined by a neck of about 4 mm radius.
const Vec3 kWanted(-9, -3, 4);
const Vec3 kBesides = kWanted + 21.4 * glm::normalize(Vec3(2, 1, -0.5));
constexpr double kBall_mm3 = 4.0 / 3.0 * std::numbers::pi * 1000;

Volume TwoBalls() {
  const auto a = Ball(kWanted, 10);
  const auto b = Ball(kBesides, 13);
  return test::MakeCt(
      {70, 56, 48}, {1, 1, 1}, {-28, -22, -22}, glm::dmat3(1), [=](const Vec3& p) { return std::min(a(p), b(p)); },
      900);
}

// Labels of DentalSegmentator, 2 for the wanted ball and 1 for the other, on a lattice; `leak_mm` beyond the balls.
Volume BallLabels(const Volume& lattice, double leak_mm = 0, bool label_other = true) {
  return test::MakeLabels(lattice, [=](const Vec3& p) {
    const double a = Ball(kWanted, 10 + leak_mm)(p), b = Ball(kBesides, 13 + leak_mm)(p);
    if (a < 0 && a <= b) return 2;
    return b < 0 && label_other ? 1 : 0;
  });
}

ImportOptions WithMask(const std::string& path) {
  const Segmentation segmentation = ReadSegmentation(path);
  ImportOptions options;
  options.voxel_mm = 0.4;
  options.isolate.iso_hu = 450;
  options.isolate.mask = std::make_shared<const BoneMask>(
      MakeBoneMask(segmentation, FindRoles(segmentation, {.preset = "dentalsegmentator", .assignments = {}})));
  return options;
}

// The largest distance of the surface of `bone` from that of `reference`, mm; points for which `skip` is true are not
// measured.
double CalcLargestDistance(const Bone& bone, const Bone& reference, const std::function<bool(const Vec3&)>& skip = {}) {
  double largest = 0;
  for (const Vec3& p : ExtractSurface(bone).points) {
    if (!skip || !skip(p)) largest = std::max(largest, std::abs(reference.SignedDistance(p)));
  }
  return largest;
}

TEST(MaskImport, SeparatesTouchingBallsWithoutAnyPoint) {
  const Folder folder;
  test::WriteNrrd(TwoBalls(), folder.file("ct.nrrd"));
  test::WriteNrrd(BallLabels(TwoBalls()), folder.file("mask.nrrd"));
  const ImportResult result = Import(folder.file("ct.nrrd"), WithMask(folder.file("mask.nrrd")));
  EXPECT_EQ(result.report.pieces, 1u);
  // As for points: the overlap is a lens of 28 mm3, and the border is known to a voxel, over 50 mm2 of neck; the border
  // of the level set lies up to a third of a voxel farther inside.
  EXPECT_NEAR(result.report.solid_mm3, kBall_mm3, 100);
  EXPECT_EQ(result.report.mask.reach_mm, 2);
  EXPECT_EQ(result.report.mask.added_mm3, 0);
  EXPECT_LT(result.report.mask.cut_off_mm3, 10);  // the other ball is a segment, but for voxels on its surface
  EXPECT_FALSE(result.report.mandible);           // its shape is reported, not required
  EXPECT_EQ(result.bone.notes().at("import_shape"), result.report.shape_objection);
  const Vec3 toward = glm::normalize(kBesides - kWanted);
  double farthest = 0, error = 0;
  for (const Vec3& p : ExtractSurface(result.bone).points) {
    const double r = glm::length(p - kWanted);
    farthest = std::max(farthest, r);
    if (glm::dot(p - kWanted, toward) < 6) error = std::max(error, std::abs(r - 10));
  }
  EXPECT_LT(farthest, 11.5);
  // Away from the neck the surface is the CT's own: that of a spline through voxels of 1 mm, and not the mask's steps,
  // which are up to 0.87 mm.
  EXPECT_LT(error, 0.15);
  EXPECT_NE(result.bone.notes().at("import_mask").find("label 2"), std::string::npos);
}

TEST(MaskImport, GivesTheSameBoneInAnyDirectionAndFormat) {
  const Folder folder;
  test::WriteNrrd(TwoBalls(), folder.file("ct.nrrd"));
  const Volume labels = BallLabels(TwoBalls());
  test::WriteNrrd(labels, folder.file("a.nrrd"));
  const Bone expected = Import(folder.file("ct.nrrd"), WithMask(folder.file("a.nrrd"))).bone;
  test::WriteNifti(labels, folder.file("ras.nii"));
  test::WriteMeta(labels, folder.file("lps.mha"));
  // Reversed axes, one of them alone (left-handed), and axes in another order.
  const auto store = [&](const glm::dmat3& axes, const std::array<int, 3>& size, const Vec3& origin) {
    Volume lattice;
    lattice.size = size;
    lattice.axes_W = axes;
    lattice.origin_W = origin;
    return BallLabels(lattice);
  };
  test::WriteNrrd(store({{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, {70, 56, 48}, {41, 33, -22}), folder.file("flipped.nrrd"));
  test::WriteNrrd(store({{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {70, 56, 48}, {41, -22, -22}), folder.file("left.nrrd"));
  test::WriteNrrd(store({{0, 0, 1}, {1, 0, 0}, {0, 1, 0}}, {48, 70, 56}, {-28, -22, -22}), folder.file("turned.nrrd"));
  std::string ras = test::NrrdHeader(labels);
  ras.replace(ras.find("left-posterior-superior"), 23, "right-anterior-superior");
  const auto negate = [&ras](const std::string& from, const std::string& to) {
    ras.replace(ras.find(from), from.size(), to);
  };
  negate("(1,0,0) (0,1,0)", "(-1,0,0) (0,-1,0)");
  negate("(-28,-22,-22)", "(28,22,-22)");
  test::WriteBytes(folder.file("ras.nrrd"), ras + "\n" + test::Bytes(labels.hu));
  for (const char* file : {"ras.nii", "lps.mha", "flipped.nrrd", "left.nrrd", "turned.nrrd", "ras.nrrd"}) {
    const Bone bone = Import(folder.file("ct.nrrd"), WithMask(folder.file(file))).bone;
    EXPECT_EQ(CalcLargestDistance(bone, expected), CalcLargestDistance(expected, expected)) << file;
  }
  // On an oblique lattice other voxels lie in the ball, so that the markers differ, but not the surface.
  const double c = std::cos(0.5), s = std::sin(0.5);
  test::WriteNrrd(store({{c, s, 0}, {-s, c, 0}, {0, 0, 1}}, {90, 90, 60}, {-10, -60, -25}),
                  folder.file("oblique.nrrd"));
  const Bone oblique = Import(folder.file("ct.nrrd"), WithMask(folder.file("oblique.nrrd"))).bone;
  EXPECT_LT(CalcLargestDistance(oblique, expected), 0.1);  // a tenth of a voxel of the CT
}

TEST(MaskImport, CoarseAndLeakingMasksGiveTheSameSurface) {
  const Folder folder;
  test::WriteNrrd(TwoBalls(), folder.file("ct.nrrd"));
  test::WriteNrrd(BallLabels(TwoBalls()), folder.file("exact.nrrd"));
  const Bone expected = Import(folder.file("ct.nrrd"), WithMask(folder.file("exact.nrrd"))).bone;
  Volume coarse;
  coarse.size = {24, 19, 17};
  coarse.spacing_mm = Vec3(3);
  coarse.origin_W = {-27.3, -21.1, -22.6};
  test::WriteNrrd(BallLabels(coarse), folder.file("coarse.nrrd"));
  test::WriteNrrd(BallLabels(TwoBalls(), 1), folder.file("leaking.nrrd"));
  test::WriteNrrd(BallLabels(TwoBalls(), -1), folder.file("small.nrrd"));
  test::WriteNrrd(BallLabels(TwoBalls(), 0, false), folder.file("alone.nrrd"));
  const Vec3 toward = glm::normalize(kBesides - kWanted);
  const auto is_neck = [&toward](const Vec3& p) { return glm::dot(p - kWanted, toward) > 7; };
  for (const char* file : {"coarse.nrrd", "leaking.nrrd", "small.nrrd", "alone.nrrd"}) {
    const ImportResult result = Import(folder.file("ct.nrrd"), WithMask(folder.file(file)));
    // The surface is the same within a tenth of a voxel of the CT. At the neck the CT decides between other markers; a
    // voxel that changes sides moves the border there, which is smoothed over 1.2 mm, by up to a quarter of a voxel.
    EXPECT_LT(CalcLargestDistance(result.bone, expected, is_neck), 0.1) << file;
    EXPECT_LT(CalcLargestDistance(result.bone, expected), 0.25) << file;
    EXPECT_EQ(result.report.mask.added_mm3, 0) << file;
  }
}

TEST(MaskImport, ReportsWhatTheMaskAddsAndCutsOff) {
  const Folder folder;
  // A ball of bone with a gap in it that opens to the outside, so that it is no cavity, joined to a rod that no segment
  // contains.
  const auto ball = Ball({0, 0, 0}, 12);
  const auto rod = [](const Vec3& p) { return std::max({std::hypot(p.y, p.z) - 3, p.x - 28, -p.x}); };
  const auto gap = [](const Vec3& p) { return std::max(std::abs(p.x) - 3.0, -p.z - 6); };
  const Volume ct = test::MakeCt(
      {66, 40, 40}, {1, 1, 1}, {-30, -20, -20}, glm::dmat3(1),
      [=](const Vec3& p) { return std::min(std::max(ball(p), -gap(p)), std::max(rod(p), 3 - p.x)); }, 900);
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  test::WriteNrrd(test::MakeLabels(ct, [&](const Vec3& p) { return ball(p) < 0 ? 2 : 0; }), folder.file("mask.nrrd"));
  ImportOptions options = WithMask(folder.file("mask.nrrd"));
  options.isolate.mask_reach_mm = 2;
  const ImportReport report = Import(folder.file("ct.nrrd"), options).report;
  // The rod is 28 mm long and begins 2 mm outside the mask at 14 mm, but the CT is cut 12 mm beyond the mask, at x
  // = 24. Its section of 28.3 mm2 has 29 voxels; the end is known to a voxel.
  EXPECT_NEAR(report.mask.cut_off_mm3, 29 * 10, 2 * 29);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("were cut off; the mask has no segment of other bone")));
  // By Pappus and by slices: within 10 mm of the middle, the gap has 6 mm x the area of the disc above z = -6; a margin
  // of a voxel on all sides is 6 mm x 60 mm of circumference, and the fill of cavities takes part of the gap.
  EXPECT_GT(report.mask.added_mm3, 0);
  EXPECT_LT(report.mask.added_mm3, 6 * std::numbers::pi * 100);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("are bone, although the CT shows none there")));
  // The picture shows the same.
  using What = MaskOverlay::What;
  const MaskOverlay overlay(ReadImageFile(folder.file("ct.nrrd")), options);
  EXPECT_EQ(overlay.added_mm3(), report.mask.added_mm3);
  EXPECT_EQ(overlay.cut_off_mm3(), report.mask.cut_off_mm3);
  EXPECT_EQ(overlay.At({18, 0, 0}), What::kCutOff);
  EXPECT_EQ(overlay.At({-7, 0, 0}), What::kKept);
  EXPECT_EQ(overlay.At({0, 0, 8}), What::kAdded);
  EXPECT_EQ(overlay.At({0, 15, 0}), What::kNothing);
  EXPECT_EQ(overlay.At({500, 0, 0}), What::kNothing);
  EXPECT_TRUE(overlay.IsInMask({0, 0, 8}) && !overlay.IsInMask({18, 0, 0}));
}

// A ball with a rod of 4 mm that ends in a block, all of the same HU: nothing in the CT says where the rod ends.
TEST(MaskImport, ThinPartsStayWithTheMaskWhereTheCtShowsNoBorder) {
  const Folder folder;
  const auto body = [](const Vec3& p) {
    return std::min(Ball({0, 0, 0}, 12)(p), std::max({std::hypot(p.y, p.z) - 2.2, p.x - 35, -p.x}));
  };
  const auto block = [](const Vec3& p) {
    return std::max({35 - p.x, p.x - 47, std::abs(p.y) - 12, std::abs(p.z) - 12});
  };
  const Volume ct = test::MakeCt(
      {70, 34, 34}, {1, 1, 1}, {-17, -16.5, -16.5}, glm::dmat3(1),
      [=](const Vec3& p) { return std::min(body(p), block(p)); }, 900);
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  test::WriteNrrd(test::MakeLabels(ct, [&](const Vec3& p) { return body(p) < 0    ? 2
                                                                   : block(p) < 0 ? 1
                                                                                  : 0; }),
                  folder.file("mask.nrrd"));
  const ImportResult result = Import(folder.file("ct.nrrd"), WithMask(folder.file("mask.nrrd")));
  // The end of the rod is known to the reach of 2 mm; nothing else of the mask is lost.
  for (double x = 10; x < 33; ++x) EXPECT_LT(result.bone.SignedDistance({x, 0, 0}), 0) << x;
  EXPECT_GT(result.bone.SignedDistance({38, 0, 0}), 0);
  EXPECT_LT(result.report.mask.given_away_mm3, 0.01 * result.report.mask.wanted_mm3);
  for (const std::string& warning : result.report.warnings) EXPECT_THAT(warning, Not(HasSubstr("the mask names")));
}

// The condyles end in blocks of bone, as in a joint without a gap. The mask is the jaw, alone or beside the blocks.
TEST(MaskImport, CondylesStayWithTheMaskWhereTheCtShowsNoJoint) {
  const Folder folder;
  const auto fossa = [](const Vec3& p) {
    return std::max({std::abs(std::abs(p.x) - 48) - 16, std::abs(p.y - 80) - 16, 30 - p.z, p.z - 60});
  };
  for (const std::int16_t block_hu : {std::int16_t{900}, std::int16_t{1200}}) {
    Volume ct;
    ct.size = {64, 51, 57};
    ct.spacing_mm = Vec3(2);
    ct.origin_W = {-64, -6.8, -45.6};
    ct = test::SampleJaw(ct);
    Volume both = ct;
    for (std::size_t v = 0; v < ct.count(); ++v) {
      const Vec3 p_W = ct.WorldFromVoxel(
          {static_cast<double>(v % 64), static_cast<double>(v / 64 % 51), static_cast<double>(v / (64 * 51))});
      both.hu[v] = static_cast<std::int16_t>(ct.hu[v] >= 300 ? 2 : fossa(p_W) < 0 ? 1 : 0);
      if (fossa(p_W) < 0) ct.hu[v] = std::max(ct.hu[v], block_hu);
    }
    Volume alone = both;
    for (std::int16_t& label : alone.hu) label = label == 2 ? label : std::int16_t{0};
    test::WriteNrrd(both, folder.file("both.nrrd"));
    test::WriteNrrd(alone, folder.file("alone.nrrd"));
    for (const std::string file : {"both.nrrd", "alone.nrrd"}) {
      ImportOptions options = WithMask(folder.file(file));
      options.isolate.iso_hu = 300;
      const Isolation isolation = Isolate(ct, options.isolate, {});
      const std::vector<std::uint8_t>& away = isolation.mask->given_away;
      const double away_mm3 = static_cast<double>(std::count(away.begin(), away.end(), 1)) * ct.CalcVoxelVolume();
      EXPECT_LT(away_mm3, 0.001 * isolation.mask->wanted_mm3) << block_hu << ' ' << file;
      // Of bone beyond the mask, what no segment names is left to the CT.
      if (file == "both.nrrd") {
        EXPECT_NEAR(isolation.iso_volume_mm3 / isolation.mask->wanted_mm3, 1, 0.002) << block_hu;
      }
      EXPECT_TRUE(isolation.mandible);
    }
  }
}

// Automatic segmentations have small islands elsewhere, in bone or of single voxels. A half that is apart is kept.
TEST(MaskImport, OfAMandibleOnlyFragmentsAreKept) {
  const Folder folder;
  const Volume jaw = test::JawCt();
  const auto import = [&](const std::function<bool(const Vec3&)>& is_island, bool cut) {
    Volume ct = jaw;
    Volume mask = test::MakeLabels(ct, [](const Vec3&) { return 0; });
    for (std::size_t v = 0; v < ct.count(); ++v) {
      const auto n = static_cast<int>(v);
      const Vec3 p_W = ct.WorldFromVoxel({n % ct.size[0], n / ct.size[0] % ct.size[1], n / (ct.size[0] * ct.size[1])});
      if (cut && std::abs(p_W.x) < 4) ct.hu[v] = 0;
      mask.hu[v] = ct.hu[v] >= 300 || is_island(p_W) ? 2 : 0;
      if (Ball({0, 76, 10}, 10)(p_W) < 0) ct.hu[v] = 900;  // as a vertebra
    }
    test::WriteNrrd(ct, folder.file("ct.nrrd"));
    test::WriteNrrd(mask, folder.file("mask.nrrd"));
    ImportOptions options = WithMask(folder.file("mask.nrrd"));
    options.voxel_mm = 1;
    options.isolate.iso_hu = 300;
    return Import(folder.file("ct.nrrd"), options).report;
  };
  const ImportReport plain = import([](const Vec3&) { return false; }, false);
  const ImportReport island = import([](const Vec3& p) { return Ball({0, 76, 10}, 6)(p) < 0; }, false);
  EXPECT_EQ(island.pieces, 1u);
  EXPECT_TRUE(island.mandible);
  EXPECT_NEAR(island.iso_mm3 / plain.iso_mm3, 1, 1e-3);
  EXPECT_EQ(import([](const Vec3&) { return false; }, true).pieces, 2u);
}

// As ribs: nothing deeper in the mask than the reach is bone by its HU, and they are not joined. A crumb is left out.
TEST(MaskImport, CortexAroundMarrowIsBoneOfTheMask) {
  const Folder folder;
  const auto tube = [](const Vec3& p, double r_mm) {
    return std::max(std::hypot(p.y, p.z) - r_mm, std::abs(p.x) - 30);
  };
  const auto second = [](const Vec3& p) { return std::max(std::hypot(p.y - 20, p.z) - 4, std::abs(p.x) - 10); };
  const auto crumb = Ball({25, 25, 0}, 2.5);
  const auto other = [=](const Vec3& p) { return std::min(second(p), crumb(p)); };
  Volume ct = test::MakeCt(
      {70, 50, 24}, {1, 1, 1}, {-34.5, -12.5, -11.5}, glm::dmat3(1),
      [=](const Vec3& p) { return std::min(tube(p, 7), other(p)); }, 900);
  for (std::size_t v = 0; v < ct.count(); ++v) {
    const Vec3 p = ct.WorldFromVoxel(
        {static_cast<double>(v % 70), static_cast<double>(v / 70 % 50), static_cast<double>(v / 3500)});
    if (tube(p, 5.2) < -1) ct.hu[v] = 100;
  }
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  test::WriteNrrd(test::MakeLabels(ct, [&](const Vec3& p) { return std::min(tube(p, 7), other(p)) < 0 ? 2 : 0; }),
                  folder.file("mask.nrrd"));
  const ImportOptions options = WithMask(folder.file("mask.nrrd"));
  const ImportReport report = Import(folder.file("ct.nrrd"), options).report;
  // The tube is filled, as marrow is: pi x 49 mm2 x 60 mm, and the second one is kept: pi x 16 mm2 x 20 mm.
  const double expected_mm3 = std::numbers::pi * (49 * 60 + 16 * 20);
  EXPECT_NEAR(report.solid_mm3, expected_mm3, 0.03 * expected_mm3);
  EXPECT_EQ(report.pieces, 2u);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("the segmentation gives 2 separate pieces of bone")));
  EXPECT_NEAR(report.mask.given_away_mm3, 65, 20);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("are not in the result, up to")));
  const MaskOverlay overlay(ReadImageFile(folder.file("ct.nrrd")), options);
  EXPECT_EQ(overlay.At({0.5, 20.5, 0.5}), MaskOverlay::What::kKept);
  EXPECT_EQ(overlay.At({24.5, 24.5, 0.5}), MaskOverlay::What::kGivenAway);
}

TEST(MaskImport, TeethAndCanalGetTheirRegions) {
  const Folder folder;
  const Volume ct =
      test::MakeCt({40, 40, 40}, {1, 1, 1}, {-19.5, -19.5, -19.5}, glm::dmat3(1), Ball({0, 0, 0}, 15), 900);
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  const auto tooth = Ball({0, 0, 8}, 5);
  const auto canal = [](const Vec3& p) { return std::hypot(p.y, p.z + 5) - 2; };
  const Volume labels = test::MakeLabels(ct, [&](const Vec3& p) {
    if (Ball({0, 0, 0}, 15)(p) >= 0) return 0;
    return tooth(p) < 0 ? 4 : canal(p) < 0 ? 5 : 2;
  });
  test::WriteNrrd(labels, folder.file("mask.nrrd"));
  const ImportResult result = Import(folder.file("ct.nrrd"), WithMask(folder.file("mask.nrrd")));
  EXPECT_NEAR(result.report.solid_mm3, 4.0 / 3 * std::numbers::pi * 3375, 150);
  // The tooth is a ball of 524 mm3; it is smoothed over half a voxel, which moves a surface of this radius by 0.1 mm.
  EXPECT_NEAR(result.report.region_mm3.at(kToothRegion), 524, 60);
  // The canal is a tube of 12.6 mm2 and 28.3 mm; its border is known to half a voxel.
  EXPECT_NEAR(result.report.region_mm3.at(kCanalRegion), 12.6 * 28.3, 70);
  EXPECT_EQ(result.bone.materials().At(kCanalRegion).tissue, Tissue::kCanal);
}

// A ball of 15 mm with two teeth that touch, a tube of metal in it, and a lesion that is soft in the CT and reaches
// beyond the bone.
class NamedStructures : public ::testing::Test {
 protected:
  static double Tooth36(const Vec3& p) { return std::max(Ball({0, 0, 8}, 5)(p), -p.x); }
  static double Tooth37(const Vec3& p) { return std::max(Ball({0, 0, 8}, 5)(p), p.x); }
  static double Metal(const Vec3& p) { return std::max(std::hypot(p.y, p.z + 5) - 2, std::abs(p.x) - 8); }
  static double Lesion(const Vec3& p) { return Ball({0, -13, 0}, 4)(p); }

  void SetUp() override {
    const auto bone = [](const Vec3& p) { return std::max(Ball({0, 0, 0}, 15)(p), -Lesion(p)); };
    const Volume ct = test::MakeCt({44, 44, 44}, {1, 1, 1}, {-21.5, -21.5, -21.5}, glm::dmat3(1), bone, 900);
    test::WriteNrrd(ct, folder_.file("ct.nrrd"));
    test::WriteSeg(test::MakeLabels(ct,
                                    [](const Vec3& p) {
                                      if (Lesion(p) < 0) return 5;
                                      if (Ball({0, 0, 0}, 15)(p) >= 0) return 0;
                                      return Tooth36(p) < 0 ? 2 : Tooth37(p) < 0 ? 3 : Metal(p) < 0 ? 4 : 1;
                                    }),
                   {{"mandible", "1"}, {"tooth 36", "2"}, {"Tooth_37", "3"}, {"implant", "4"}, {"lesion", "5"}},
                   folder_.file("mask.seg.nrrd"));
  }
  ImportOptions MakeOptions() const {
    const Segmentation segmentation = ReadSegmentation(folder_.file("mask.seg.nrrd"));
    ImportOptions options;
    options.voxel_mm = 0.4;
    options.isolate.iso_hu = 450;
    options.isolate.mask = std::make_shared<const BoneMask>(MakeBoneMask(segmentation, FindRoles(segmentation, {})));
    return options;
  }
  void ExpectRegions(const ImportResult& result) const {
    const auto& mm3 = result.report.region_mm3;
    // The surfaces of these regions are known to about a tenth of a voxel of 1 mm.
    EXPECT_NEAR(mm3.at(ToothRegion(36)), 262, 40);
    EXPECT_NEAR(mm3.at(ToothRegion(37)), 262, 40);
    EXPECT_FALSE(mm3.contains(kToothRegion));
    EXPECT_NEAR(mm3.at(kMetalRegion), 4 * std::numbers::pi * 16, 40);
    EXPECT_NEAR(mm3.at(kLesionRegion), 4.0 / 3 * std::numbers::pi * 64, 40);
    EXPECT_EQ(result.bone.RegionAt({0.6, 0, 8}), ToothRegion(36));
    EXPECT_EQ(result.bone.RegionAt({-0.6, 0, 8}), ToothRegion(37));
    const MaterialTable& table = result.bone.materials();
    EXPECT_EQ(table.At(ToothRegion(36)).name, "tooth 36");
    EXPECT_EQ(table.At(ToothRegion(36)).E_MPa, table.At(kToothRegion).E_MPa);
    EXPECT_EQ(table.At(kMetalRegion).tissue, Tissue::kMetal);
    EXPECT_EQ(table.At(kLesionRegion).tissue, Tissue::kLesion);
    EXPECT_THAT(result.report.warnings, Not(Contains(HasSubstr("of which"))));
  }
  const Folder folder_;
};

TEST_F(NamedStructures, BecomeRegionsOfTheirOwn) {
  ExpectRegions(Import(folder_.file("ct.nrrd"), MakeOptions()));
}

TEST_F(NamedStructures, BecomeRegionsWithoutACtToo) {
  ExpectRegions(Import("", MakeOptions()));
}

TEST_F(NamedStructures, DoNotTakeRegionsThatATableNeedsForOthers) {
  ImportOptions options = MakeOptions();
  options.materials = DefaultMandibleTable();
  options.materials->Add(
      {.id = kMetalRegion, .name = "mine", .tissue = Tissue::kOther, .E_MPa = 1, .nu = 0.3, .source = "test"});
  options.materials_name = "t.csv";
  EXPECT_EQ(MessageOf([&] { Import(folder_.file("ct.nrrd"), options); }),
            "t.csv: region 35 is 'mine', but an import with this mask needs it for 'metal'");
}

TEST_F(NamedStructures, ThatAreNotInTheBoneAreReported) {
  // Metal as bright as soft tissue, outside of the bone.
  const Volume ct = ReadImageFile(folder_.file("ct.nrrd"));
  test::WriteSeg(test::MakeLabels(ct,
                                  [](const Vec3& p) {
                                    return Ball({0, 0, 0}, 15)(p) < 0 ? 1 : Ball({0, 0, 19}, 3)(p) < 0 ? 2 : 0;
                                  }),
                 {{"mandible", "1"}, {"plate", "2"}}, folder_.file("mask.seg.nrrd"));
  EXPECT_THAT(Import(folder_.file("ct.nrrd"), MakeOptions()).report.warnings,
              Contains(HasSubstr("of metal, of which 0 mm3 are in the bone")));
}

TEST(MaskImport, MetalAndTeethHaveNoSkinOfBoneWhereTheCtIsLarger) {
  // A ball of 12 mm whose labels end at 11 mm: metal above z = 4, a tooth below z = -4, bone between.
  const Folder folder;
  const Volume ct = test::MakeCt({40, 40, 40}, {0.8, 0.8, 0.8}, Vec3(-15.6), glm::dmat3(1), Ball({0, 0, 0}, 12), 900);
  test::WriteNrrd(ct, folder.file("ct.nrrd"));
  test::WriteSeg(test::MakeLabels(ct,
                                  [](const Vec3& p) {
                                    if (Ball({0, 0, 0}, 11)(p) >= 0) return 0;
                                    return p.z > 4 ? 2 : p.z < -4 ? 3 : 1;
                                  }),
                 {{"mandible", "1"}, {"implant", "2"}, {"tooth 36", "3"}}, folder.file("mask.seg.nrrd"));
  const Segmentation segmentation = ReadSegmentation(folder.file("mask.seg.nrrd"));
  ImportOptions options;
  options.voxel_mm = 0.4;
  options.isolate.iso_hu = 450;
  options.isolate.mask = std::make_shared<const BoneMask>(MakeBoneMask(segmentation, FindRoles(segmentation, {})));
  const Bone bone = Import(folder.file("ct.nrrd"), options).bone;
  for (const Vec3& p : ExtractSurface(bone).points) {
    const Vec3 below = p - 0.3 * glm::normalize(p);
    // The border of the labels, continued along the radius, is at 4.4 mm; it is known to a voxel of 0.8 mm on both
    // sides.
    if (std::abs(p.z) < 6) continue;
    EXPECT_EQ(bone.RegionAt(below), p.z > 0 ? kMetalRegion : ToothRegion(36)) << p.x << ' ' << p.y << ' ' << p.z;
  }
  // A cap of 8 mm of the ball; its plane is known to half a voxel, 0.4 mm of 402 mm2.
  EXPECT_NEAR(bone.CalcRegionVolumes().at(kMetalRegion), std::numbers::pi * 64 * (3 * 12 - 8) / 3, 160);
}

TEST(MaskImport, RefusesMasksOfAnotherScan) {
  const Folder folder;
  test::WriteNrrd(TwoBalls(), folder.file("ct.nrrd"));
  Volume labels = BallLabels(TwoBalls());
  labels.origin_W += Vec3(100, 0, 0);
  test::WriteNrrd(labels, folder.file("mask.nrrd"));
  EXPECT_THAT(
      MessageOf([&] { Import(folder.file("ct.nrrd"), WithMask(folder.file("mask.nrrd"))); }),
      HasSubstr("100 % of the wanted bone of the mask lies outside the scan; the mask belongs to another scan"));
  labels.origin_W -= Vec3(100, 0, 18);
  test::WriteNrrd(labels, folder.file("mask.nrrd"));
  EXPECT_THAT(MessageOf([&] { Import(folder.file("ct.nrrd"), WithMask(folder.file("mask.nrrd"))); }),
              HasSubstr("% of the wanted bone of the mask lies in bone above 450 HU"));
}

TEST(MaskImport, SaysThatTheMaskHasAnotherFrameOfReference) {
  const Folder folder;
  const Volume ct = TwoBalls();
  std::filesystem::create_directory(folder.file("ct"));
  test::WriteDicom(ct, folder.file("ct"));  // in the frame 1.2.4
  test::WriteNrrd(BallLabels(ct), folder.file("mask.nrrd"));
  ImportOptions options = WithMask(folder.file("mask.nrrd"));
  for (const std::string uid : {"", "1.2.4", "1.2.5"}) {
    BoneMask mask = *options.isolate.mask;
    mask.frame_uid = uid;
    options.isolate.mask = std::make_shared<const BoneMask>(std::move(mask));
    const std::vector<std::string> warnings = Import(folder.file("ct"), options).report.warnings;
    EXPECT_EQ(std::ranges::any_of(warnings,
                                  [](const std::string& warning) {
                                    return warning.find("different frames of reference") != std::string::npos;
                                  }),
              uid == "1.2.5")
        << uid;
  }
}

TEST(MaskImport, WithoutACtTheBoneIsThatOfTheLabels) {
  const Folder folder;
  // An oblique lattice whose axes are stored backwards.
  Volume lattice;
  lattice.size = {120, 120, 100};
  lattice.spacing_mm = {0.4, 0.4, 0.5};
  const double c = std::cos(0.4), s = std::sin(0.4);
  lattice.axes_W = {{-c, -s, 0}, {s, -c, 0}, {0, 0, 1}};
  lattice.origin_W = kWanted - lattice.axes_W * (0.5 * lattice.spacing_mm * Vec3(120, 120, 100));
  test::WriteNrrd(BallLabels(lattice), folder.file("mask.nrrd"));
  const ImportResult result = Import("", WithMask(folder.file("mask.nrrd")));
  EXPECT_EQ(result.report.kind, "mask");
  // The staircase is smoothed over a voxel; the volume of the labels is that of the ball within half a percent.
  EXPECT_NEAR(result.report.solid_mm3, result.report.mask.wanted_mm3, 0.02 * kBall_mm3);
  EXPECT_NEAR(result.report.solid_mm3, kBall_mm3, 0.02 * kBall_mm3);
  EXPECT_LT(glm::length(result.report.box.centre() - kWanted), 0.5);
  EXPECT_THAT(result.report.warnings, Contains(HasSubstr("made without a CT")));
  // The cortex is as thick as the option says, 2 mm, within one voxel of 0.4 mm, since its depth is counted from
  // voxels.
  EXPECT_NEAR(std::cbrt(result.report.region_mm3.at(kCancellousRegion) * 3 / (4 * std::numbers::pi)), 8, 0.4);
  EXPECT_FALSE(result.report.cut_by_scan);
  // Half of the ball: cut off by the edge of the scan, unless the file lacks slices without a segment.
  lattice.size[2] = 50;
  test::WriteNrrd(BallLabels(lattice), folder.file("half.nrrd"));
  ImportOptions half = WithMask(folder.file("half.nrrd"));
  EXPECT_TRUE(Import("", half).report.cut_by_scan);
  BoneMask cropped = *half.isolate.mask;
  cropped.cropped = true;
  half.isolate.mask = std::make_shared<const BoneMask>(std::move(cropped));
  EXPECT_FALSE(Import("", half).report.cut_by_scan);
  ImportOptions keep = WithMask(folder.file("mask.nrrd"));
  keep.keep_hu = true;
  EXPECT_THAT(MessageOf([&] { Import("", keep); }), HasSubstr("has no CT numbers to keep"));
}

TEST(MaskImport, ShearedMaskWithoutACtIsStraightened) {
  const Folder folder;
  // Slices of a gantry that is tilted by 20 degrees: each is shifted to the back.
  Volume lattice;
  lattice.size = {60, 80, 60};
  lattice.spacing_mm = {0.5, 0.5, 0.5 / std::cos(0.35)};
  lattice.axes_W[2] = {0, std::sin(0.35), std::cos(0.35)};
  lattice.origin_W = kWanted - lattice.axes_W * (0.5 * lattice.spacing_mm * Vec3(60, 80, 60));
  test::WriteNrrd(BallLabels(lattice), folder.file("mask.nrrd"));
  const ImportResult result = Import("", WithMask(folder.file("mask.nrrd")));
  EXPECT_NEAR(result.report.solid_mm3, kBall_mm3, 0.02 * kBall_mm3);
  EXPECT_LT(glm::length(result.report.box.centre() - kWanted), 0.5);
  EXPECT_THAT(result.report.warnings, Contains(HasSubstr("not at right angles: it was sampled")));
}

TEST(MaskImport, TheLibraryGivesTheBoneOfTheProgram) {
  const Folder folder;
  const std::string ct = folder.file("ct.nrrd"), mask = folder.file("mask.nrrd");
  test::WriteNrrd(TwoBalls(), ct);
  test::WriteNrrd(BallLabels(TwoBalls()), mask);
  ImportSettings settings;
  settings.voxel_mm = 0.4;
  settings.iso_hu = 450;
  settings.mask = mask;
  settings.mask_labels = "dentalsegmentator";
  const ImportedBone imported = ImportBone(ct, settings);
  EXPECT_EQ(imported.bone.CalcHash(), Import(ct, WithMask(mask)).bone.CalcHash());
  EXPECT_EQ(ImportBone("", settings).bone.CalcHash(), Import("", WithMask(mask)).bone.CalcHash());
  settings.mask_labels = "";
  settings.mask_label = {"2=mandible", "1=other"};
  EXPECT_EQ(ImportBone(ct, settings).bone.CalcHash(), imported.bone.CalcHash());

  const auto refusal = [](const std::string& path, const ImportSettings& wrong) {
    return MessageOf([&] { ImportBone(path, wrong); });
  };
  EXPECT_THAT(refusal("bone.stl", settings), HasSubstr("bone.stl: a mask applies to a CT only"));
  settings.isolate = false;
  EXPECT_THAT(refusal(ct, settings), HasSubstr("the mask selects one"));
  settings = {};
  EXPECT_THAT(refusal("", settings), HasSubstr("neither a CT, a surface nor a mask is given"));
  settings.mask_reach_mm = 2;
  EXPECT_THAT(refusal(ct, settings), HasSubstr("apply to a mask only"));
}

const std::string kPhantomFolder = std::string(KERF_TEST_DATA) + "/phantom_siemens/dicom";
const std::string kFemaleFile =
    std::string(KERF_TEST_DATA) + "/visible_human_female/vhf_head_hu_int16_250x250x234.nrrd";

// Returns the bone of an isolation as labels on its lattice: 2 for it, 1 for other bone.
Volume LabelsOf(const Isolation& isolation, double iso_hu) {
  Volume labels = isolation.ct;
  for (std::size_t v = 0; v < labels.hu.size(); ++v)
    labels.hu[v] = static_cast<std::int16_t>(isolation.bone[v] != 0 ? 2 : isolation.ct.hu[v] >= iso_hu ? 1 : 0);
  return labels;
}

TEST(MaskImportPhantom, IsSeparatedWithoutAnyPoint) {
  if (!std::filesystem::exists(kPhantomFolder)) GTEST_SKIP() << "not found: " << kPhantomFolder;
  ImportOptions points;
  points.voxel_mm = 0.5;
  points.isolate.keep_W = ReadMarkups(std::string(KERF_SOURCE_DIR) + "/scenes/phantom_keep.mrk.json");
  points.isolate.drop_W = ReadMarkups(std::string(KERF_SOURCE_DIR) + "/scenes/phantom_drop.mrk.json");
  ImportReport read;
  const Volume ct = StoreAlongPatient(ReadCt(kPhantomFolder, points, read));
  const Isolation isolation = Isolate(ct, points.isolate, {});
  // The mask knows the mandible only, on a lattice of 2 mm with other axes, as a program that segments at that
  // resolution would write it.
  const Volume fine = LabelsOf(isolation, 300);
  Volume lattice;
  lattice.spacing_mm = Vec3(2);
  lattice.axes_W = {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}};
  lattice.origin_W = fine.WorldFromVoxel({fine.size[0] - 1.0, fine.size[1] - 1.0, 0}) + Vec3(0.4, -0.3, 0.7);
  for (std::size_t a = 0; a < 3; ++a)
    lattice.size[a] = static_cast<int>(fine.size[a] * fine.spacing_mm[static_cast<int>(a)] / 2);
  const Volume labels = test::MakeLabels(lattice, [&fine](const Vec3& p_W) {
    const Vec3 p_V = glm::round(fine.VoxelFromWorld(p_W));
    const std::array<int, 3> at = {static_cast<int>(p_V.x), static_cast<int>(p_V.y), static_cast<int>(p_V.z)};
    return fine.Contains(at) && fine.hu[fine.Index(at[0], at[1], at[2])] == 2 ? 2 : 0;
  });
  const Folder folder;
  test::WriteNrrd(labels, folder.file("mask.nrrd"));
  ImportOptions options = WithMask(folder.file("mask.nrrd"));
  options.voxel_mm = 0.5;
  options.isolate.iso_hu = 300;
  const ImportResult result = Import(kPhantomFolder, options);
  const ImportResult expected = Import(kPhantomFolder, points);
  EXPECT_TRUE(result.report.mandible) << result.report.shape_objection;
  EXPECT_EQ(result.report.pieces, 1u);
  EXPECT_NEAR(result.report.solid_mm3 / expected.report.solid_mm3, 1, 0.03);
  double top = 0;
  for (const Vec3& p : ExtractSurface(result.bone).points) {
    if (std::abs(p.x) < 30) top = std::max(top, p.z);
  }
  EXPECT_LT(top, 382);  // no part of the upper teeth, as in the test with points
}

TEST(MaskImportVisibleHuman, ItsOwnResultAsAMaskGivesTheSameBone) {
  if (!std::filesystem::exists(kFemaleFile)) GTEST_SKIP() << "not found: " << kFemaleFile;
  ImportOptions automatic;
  automatic.voxel_mm = 0.5;
  const Volume ct = StoreAlongPatient(ReadImageFile(kFemaleFile));
  const Folder folder;
  test::WriteNrrd(LabelsOf(Isolate(ct, automatic.isolate, {}), 300), folder.file("mask.nrrd"));
  ImportOptions options = WithMask(folder.file("mask.nrrd"));
  options.voxel_mm = 0.5;
  options.isolate.iso_hu = 300;
  const ImportResult by_mask = Import(kFemaleFile, options);
  const ImportResult by_itself = Import(kFemaleFile, automatic);
  EXPECT_TRUE(by_mask.report.mandible);
  EXPECT_LT(CalcLargestDistance(by_mask.bone, by_itself.bone), 0.5);  // half a voxel of the CT
}

}  // namespace
}  // namespace kerf
