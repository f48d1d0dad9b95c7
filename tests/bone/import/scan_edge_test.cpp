// Bone that is cut off where the scan ends: at the border of the image, at padding, or at a round field of view.
#include "bone/import/scan_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "bone/import/dicom.h"
#include "bone/import/import.h"
#include "bone/import/padding.h"
#include "ct_files.h"
#include "dicom_bytes.h"
#include "support/jaw_ct.h"

namespace kerf {
namespace {

using test::Folder;

constexpr std::int16_t kOutsideAir = -1000;

// Sets the voxels beyond a distance from an axis along z.
void SetOutside(double x, double y, double radius_mm, std::int16_t value, Volume& ct) {
  for (std::size_t v = 0, k = 0; k < static_cast<std::size_t>(ct.size[2]); ++k) {
    for (int j = 0; j < ct.size[1]; ++j) {
      for (int i = 0; i < ct.size[0]; ++i, ++v) {
        const Vec3 p = ct.WorldFromVoxel({i, j, static_cast<double>(k)});
        if (std::hypot(p.x - x, p.y - y) > radius_mm) ct.hu[v] = value;
      }
    }
  }
}

double CalcCut(const Volume& ct) {
  IsolateOptions all;
  all.isolate = false;
  return Isolate(ct, all, {}).cut_mm2;
}

TEST(ScanEdge, AreaOfABallCutByABorderOrByPadding) {
  // The last voxels lie 4 mm beside the centre, and the 300 HU level 0.2 mm outside the ball.
  const double disc_mm2 = std::numbers::pi * (10.2 * 10.2 - 4 * 4);
  const auto ball = test::Ball(Vec3(0), 10);
  const Volume cut = test::MakeCt({17, 30, 30}, Vec3(1), {-12, -15, -15}, glm::dmat3(1), ball);
  EXPECT_NEAR(CalcCut(cut), disc_mm2, 0.05 * disc_mm2);
  const Volume whole = test::MakeCt({30, 30, 30}, Vec3(1), {-12, -15, -15}, glm::dmat3(1), ball);
  EXPECT_EQ(CalcCut(whole), 0);
  Volume padded = whole;
  for (std::size_t v = 0; v < padded.hu.size(); ++v) {
    if (v % 30 >= 17) padded.hu[v] = -32000;
  }
  ClearPadding(padded);
  EXPECT_NEAR(CalcCut(padded), disc_mm2, 0.05 * disc_mm2);
  // Only what reaches the border is padding, not a hole in the scan.
  for (std::size_t v = 29; v < padded.hu.size(); v += 30) padded.padding[v] = false, padded.hu[v] = 40;
  EXPECT_EQ(CalcCut(padded), 0);
}

TEST(ScanEdge, PaddingOfAFineScanIsFoundOnItsOwnVoxels) {
  const double disc_mm2 = std::numbers::pi * (64 - 2 * 2);
  Volume ct = test::MakeCt({60, 60, 60}, Vec3(0.3), {-8.85, -8.85, -8.85}, glm::dmat3(1), test::Ball(Vec3(0), 8));
  for (std::size_t v = 0; v < ct.hu.size(); ++v) {
    if (ct.WorldFromVoxel({static_cast<double>(v % 60), 0, 0}).x > 2.1) ct.hu[v] = -32000;
  }
  ClearPadding(ct);
  EXPECT_NEAR(CalcCut(ct), disc_mm2, 0.08 * disc_mm2);
}

// A bar of bone in soft tissue, 20 x 20 mm thick, that a round field of view cuts off at one end.
TEST(ScanEdge, AirOfOneValueOutsideACircleIsPadding) {
  const auto bar = [](double from, double to) {
    return test::MakeCt({80, 80, 30}, Vec3(1), {-40, -40, -15}, glm::dmat3(1), [=](const Vec3& p) {
      return std::max({p.x - to, from - p.x, std::abs(p.y) - 10, std::abs(p.z) - 10});
    });
  };
  for (const double x : {0.0, 4.0}) {  // also where the circle is not in the middle
    Volume cut = bar(-10, 50);
    SetOutside(x, 0, 32, kOutsideAir, cut);
    const double deep_mm = 32 - std::sqrt(32 * 32 - 100);         // of the circle across the bar: steps on either side
    EXPECT_NEAR(CalcCut(cut), 21 * (21 + 2 * deep_mm), 30) << x;  // 21 rows of voxels are bone
  }
  Volume inside = bar(-10, 20);
  SetOutside(0, 0, 32, kOutsideAir, inside);
  EXPECT_EQ(CalcCut(inside), 0);
}

// A dry bone in air without noise touches the air everywhere, and none of it is the edge of a scan.
TEST(ScanEdge, AirAroundADryBoneIsNoPadding) {
  Volume ct = test::JawCt();
  for (std::int16_t& hu : ct.hu) hu = hu < 300 ? kOutsideAir : hu;
  EXPECT_EQ(CalcCut(ct), 0);
  // Nor is the circle of a shaft.
  ct = test::MakeCt({60, 60, 30}, Vec3(1), {-30, -30, -15}, glm::dmat3(1),
                    [](const Vec3& p) { return std::max(std::hypot(p.x, p.y) - 12, std::abs(p.z) - 12); });
  for (std::int16_t& hu : ct.hu) hu = hu < 300 ? kOutsideAir : hu;
  EXPECT_EQ(CalcCut(ct), 0);
}

class PaddedJaw : public ::testing::Test {
 protected:
  // Writes slices whose pixels outside a circle are `stored`.
  void Write(double radius_mm, int stored, bool tagged) {
    constexpr std::int16_t kMark = 32767;
    Volume jaw = test::JawCt();
    SetOutside(0, 43, radius_mm, kMark, jaw);
    for (int k = 0; k < jaw.size[2]; ++k) {
      std::string pixels;
      for (int v = 0; v < jaw.size[0] * jaw.size[1]; ++v) {
        const int hu = jaw.hu[jaw.Index(0, 0, k) + static_cast<std::size_t>(v)];
        const int word = hu == kMark ? stored : hu + 1024;
        pixels += {static_cast<char>(word & 0xff), static_cast<char>(word >> 8 & 0xff)};
      }
      test::SliceSpec spec;
      spec.pixels = pixels;
      test::DicomBytes file(test::DicomSlice(jaw, k, spec));
      if (tagged)
        file.Set(0x28, 0x120, "US", {static_cast<char>(stored & 0xff), static_cast<char>(stored >> 8 & 0xff)});
      test::WriteBytes(folder_.file(fmt::format("{:03}.dcm", k)), file.File());
    }
  }
  ImportReport Read(const std::string& path) {
    ImportOptions options;
    options.voxel_mm = 1;
    options.isolate.check_shape = false;
    const ImportResult result = Import(path, options);
    EXPECT_EQ(result.bone.notes().count("import_cut_by_scan") == 1, result.report.cut_by_scan);
    return result.report;
  }
  const Folder folder_;
};

TEST_F(PaddedJaw, IsCutByTheScanWhateverThePaddingIs) {
  double known_mm2 = 0;
  for (const auto& [stored, tagged] : {std::pair(63536, true), std::pair(63536, false), std::pair(24, false),
                                       std::pair(24, true), std::pair(0, false), std::pair(5000, true)}) {
    Write(50, stored, tagged);
    const ImportReport cut = Read(folder_.path());
    EXPECT_TRUE(cut.cut_by_scan) << stored;
    EXPECT_GT(cut.cut_mm2, 50) << stored;
    if (known_mm2 == 0) known_mm2 = cut.cut_mm2;
    EXPECT_NEAR(cut.cut_mm2, known_mm2, 0.1 * known_mm2) << stored;
    Write(66, stored, tagged);
    const ImportReport whole = Read(folder_.path());
    EXPECT_FALSE(whole.cut_by_scan) << stored;
    EXPECT_EQ(whole.cut_mm2, 0) << stored;
    EXPECT_LT(cut.iso_mm3, 0.98 * whole.iso_mm3);
  }
}

TEST_F(PaddedJaw, IsCutByTheScanWhereValuesAreNoNumbers) {
  for (const double radius_mm : {50.0, 66.0}) {
    Volume jaw = test::JawCt();
    constexpr std::int16_t kMark = 32767;
    SetOutside(0, 43, radius_mm, kMark, jaw);
    std::vector<float> values(jaw.hu.begin(), jaw.hu.end());
    for (float& value : values) {
      if (value == kMark) value = std::numeric_limits<float>::quiet_NaN();
    }
    const std::string bytes(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
    test::WriteBytes(folder_.file("a.nrrd"), test::NrrdHeader(jaw, "float") + "\n" + bytes);
    // NIfTI is stored from the right, so that its voxels, and what is known of them, are put into another order.
    std::string header = test::NiftiHeader(jaw);
    test::Put(header, 70, std::int16_t{16});
    test::Put(header, 72, std::int16_t{32});
    test::WriteBytes(folder_.file("a.nii"), header + bytes);
    for (const char* name : {"a.nrrd", "a.nii"}) {
      EXPECT_EQ(Read(folder_.file(name)).cut_by_scan, radius_mm == 50) << name << " " << radius_mm;
    }
  }
}

}  // namespace
}  // namespace kerf
