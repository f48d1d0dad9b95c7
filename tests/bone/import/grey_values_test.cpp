// Scans whose values are a linear function of HU: cone-beam CT, 8 and 12 bits.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "bone/import/hu_check.h"
#include "bone/import/import.h"
#include "ct_files.h"
#include "dicom_bytes.h"
#include "support/jaw_ct.h"

namespace kerf {
namespace {

using test::Folder;
using test::MessageOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Not;

// Returns the jaw with noise as of a cone-beam CT, and its values as offset + scale * (HU + 1000), clamped to a range.
Volume GreyJaw(double scale, double offset, double noise_hu = 0, int lowest = -32768, int highest = 32767) {
  Volume ct = test::JawCt(2);
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1);
  for (std::int16_t& value : ct.hu) {
    const double hu = value + noise_hu * noise(random);
    value = static_cast<std::int16_t>(std::clamp<long>(std::lround(offset + scale * (hu + 1000)), lowest, highest));
  }
  return ct;
}

TEST(GreyValues, ScaleIsFoundForAnyOffsetScaleAndNoise) {
  for (const double noise : {0.0, 50.0, 100.0}) {
    for (const auto& [scale, offset] : {std::pair(0.6, 300.0), std::pair(0.3, 0.0), std::pair(0.3, 2000.0),
                                        std::pair(3.0, 0.0), std::pair(3.0, 2000.0), std::pair(1.0, 500.0),
                                        std::pair(0.6, -1500.0), std::pair(1.5, -3000.0), std::pair(0.9, 150.0)}) {
      const Volume ct = GreyJaw(scale, offset, noise);
      const auto grey = FindGreyScale(ct);
      ASSERT_TRUE(grey) << scale << " " << offset << " " << noise;
      // A bin of the histogram is 1/200 of the range of the values, and the peaks are centred to one bin.
      EXPECT_NEAR(grey->FromHu(300), offset + 1300 * scale, 0.02 * 3000 * scale) << scale << " " << offset;
    }
  }
}

TEST(GreyValues, ScaleIsFoundIn8And12Bits) {
  EXPECT_TRUE(FindGreyScale(GreyJaw(1.0 / 12, 0, 0, 0, 255)));
  EXPECT_TRUE(FindGreyScale(GreyJaw(1.0 / 12, 0, 60, 0, 255)));
  EXPECT_TRUE(FindGreyScale(GreyJaw(1, 0, 60, 0, 4095)));
  EXPECT_TRUE(FindGreyScale(GreyJaw(0.6, 300, 60, 0, 1500)));
}

TEST(GreyValues, ScaleIsFoundInCoarseSteps) {
  for (const auto& [step, scale, offset] :
       {std::tuple(12.8, 0.4, 380.0), std::tuple(16.0, 0.5, 0.0), std::tuple(16.0, 1.0, 700.0)}) {
    Volume ct = GreyJaw(scale, offset, 100);
    for (std::int16_t& value : ct.hu) value = static_cast<std::int16_t>(std::lround(step * std::round(value / step)));
    const auto grey = FindGreyScale(ct);
    ASSERT_TRUE(grey) << step << " " << scale;
    EXPECT_NEAR(grey->FromHu(300), offset + 1300 * scale, 40 * scale) << step << " " << scale;  // about a step
  }
}

// As of air around the head and a headrest, or air inside and outside the field of view.
TEST(GreyValues, SecondPeakOfAirIsNotSoftTissue) {
  for (const double noise : {0.0, 5.0, 10.0}) {
    Volume ct = GreyJaw(0.6, 300, noise);
    for (std::size_t v = 0; v < ct.hu.size(); ++v) {
      if (v < ct.hu.size() / 2) ct.hu[v] = ct.hu[v % 20];  // air, of which there is then more than soft tissue
      if (v % 3 != 0 && ct.hu[v] < 350) ct.hu[v] = static_cast<std::int16_t>(ct.hu[v] + 40);
    }
    const auto grey = FindGreyScale(ct);
    ASSERT_TRUE(grey) << noise;
    EXPECT_NEAR(grey->FromHu(300), 1080, 36) << noise;
  }
}

TEST(GreyValues, HuWithADoubledSlopeAreNamed) {
  for (const double offset : {-2000.0, -976.0}) {
    EXPECT_THAT(MessageOf([&] { CheckHu(GreyJaw(2, offset, 50), 300, "a.nrrd"); }),
                HasSubstr("they lie twice as far apart as in HU, as if the rescale slope were doubled"));
  }
  EXPECT_THAT(MessageOf([&] { CheckHu(GreyJaw(0.6, 300, 50), 300, "a.nrrd"); }), Not(HasSubstr("twice")));
}

TEST(GreyValues, PaddingOutsideTheFieldOfViewIsNotAir) {
  for (const int padding : {0, -1024, -32768}) {
    Volume ct = GreyJaw(0.6, 300, 60);
    for (int k = 0; k < ct.size[2]; ++k) {
      for (int j = 0; j < ct.size[1]; ++j) {
        for (int i = 0; i < ct.size[0]; ++i) {
          if (std::hypot(i - 31.5, j - 25) > 33) ct.hu[ct.Index(i, j, k)] = static_cast<std::int16_t>(padding);
        }
      }
    }
    const auto grey = FindGreyScale(ct);
    ASSERT_TRUE(grey) << padding;
    EXPECT_NEAR(grey->FromHu(300), 1080, 40) << padding;
  }
}

TEST(GreyValues, HuAreNeverTakenForGreyValues) {
  for (const double noise : {0.0, 20.0, 100.0}) {
    EXPECT_FALSE(FindGreyScale(GreyJaw(1, -1000, noise))) << noise;
    EXPECT_FALSE(FindGreyScale(GreyJaw(1, -1000, noise, -1024, 3071))) << noise;
    EXPECT_FALSE(FindGreyScale(GreyJaw(1.1, -1050, noise))) << noise;  // as of a badly calibrated scanner
    Volume padded = GreyJaw(1, -1000, noise);
    for (std::size_t v = 0; v < padded.hu.size(); v += 5) padded.hu[v] = -2000;
    EXPECT_FALSE(FindGreyScale(padded)) << noise;
  }
  // Dry bone in air, and a crop of bone and soft tissue.
  Volume dry = GreyJaw(1, -1000, 20);
  for (std::int16_t& hu : dry.hu) hu = hu < 200 ? std::int16_t{-1000} : hu;
  EXPECT_FALSE(FindGreyScale(dry));
  Volume crop = GreyJaw(1, -1000, 20);
  for (std::int16_t& hu : crop.hu) hu = std::max<std::int16_t>(hu, -100);
  EXPECT_FALSE(FindGreyScale(crop));
}

TEST(GreyValues, ThresholdThatDoesNotFitIsRefusedWithAProposal) {
  const Volume ct = GreyJaw(0.6, 300);
  try {
    CheckHu(ct, 300, "a.nrrd");
    FAIL();
  } catch (const NotHu& e) {
    EXPECT_THAT(e.what(), HasSubstr("a.nrrd: these values are not HU: air lies near 300, soft tissue near 9"));
    EXPECT_THAT(e.what(), HasSubstr("bone from about 1100; import with --iso auto (threshold 108"));
    EXPECT_NEAR(e.proposed_iso(), 1080, 5);
    EXPECT_NEAR(e.scale().air, 300, 5);
    EXPECT_NEAR(e.scale().soft, 924, 5);
  }
  EXPECT_THAT(CheckHu(ct, 1100, ""), HasSubstr("these values are not HU"));
}

TEST(GreyValues, HistogramShowsThePeaksOfTheScale) {
  const Volume ct = GreyJaw(0.6, 300);
  const ValueHistogram histogram = CalcHistogram(ct, 50, {1080, 2200});
  EXPECT_EQ(histogram.lower, 300);
  EXPECT_EQ(histogram.upper, 2200);
  std::vector<std::size_t> bins(50);
  std::iota(bins.begin(), bins.end(), 0);
  std::sort(bins.begin(), bins.end(),
            [&](std::size_t a, std::size_t b) { return histogram.fractions[a] > histogram.fractions[b]; });
  const std::set<std::size_t> peaks(bins.begin(), bins.begin() + 2);
  EXPECT_EQ(peaks, (std::set<std::size_t>{0, static_cast<std::size_t>((924 - 300) / 38.0)}));
  EXPECT_NEAR(std::accumulate(histogram.fractions.begin(), histogram.fractions.end(), 0.0), 1, 1e-9);
}

// The volume of the bone that is imported from a CT.
ImportReport ImportJaw(const Volume& ct, double iso, bool automatic) {
  const Folder folder;
  test::WriteNrrd(ct, folder.file("a.nrrd"));
  ImportOptions options;
  options.voxel_mm = 0.6;
  options.isolate.iso_hu = iso;
  options.iso_auto = automatic;
  return Import(folder.file("a.nrrd"), options).report;
}

TEST(GreyValues, ImportGivesTheBoneAndTheTeethOfTheSameScanInHu) {
  const ImportReport plain = ImportJaw(GreyJaw(1, -1000), 300, false);
  for (const auto& [ct, iso, automatic, file_iso] :
       {std::tuple(GreyJaw(0.6, 300), 300.0, true, 1080.0), std::tuple(GreyJaw(0.6, 300), 1080.0, false, 1080.0),
        std::tuple(GreyJaw(3, 500), 4400.0, false, 4400.0),
        std::tuple(GreyJaw(1.0 / 12, 0, 0, 0, 255), 0.0, true, 108.0)}) {
    const ImportReport grey = ImportJaw(ct, iso, automatic);
    EXPECT_TRUE(grey.mandible);
    // Rounding of the values to 12 HU moves the surface of a blurred edge of 860 HU in 2 mm by 0.03 mm.
    EXPECT_NEAR(grey.solid_mm3, plain.solid_mm3, 0.01 * plain.solid_mm3);
    EXPECT_NEAR(grey.tooth_mm3, plain.tooth_mm3, 0.1 * plain.tooth_mm3);
    EXPECT_NEAR(grey.iso, file_iso, 0.01 * file_iso);
    EXPECT_THAT(grey.warnings, Contains(HasSubstr("CT numbers do not give moduli")));
  }
  const ImportReport same = ImportJaw(GreyJaw(1, -1000), 0, true);
  EXPECT_EQ(same.solid_mm3, plain.solid_mm3);
  EXPECT_EQ(same.iso, 300);
}

TEST(GreyValues, ADicomSeriesOf8BitsIsNoLabelMap) {
  const Volume ct = GreyJaw(1.0 / 12, 0, 0, 0, 255);
  const Folder folder;
  for (int k = 0; k < ct.size[2]; ++k) {
    test::SliceSpec spec;
    spec.intercept = 0;
    spec.slope = 1;
    const std::size_t plane = ct.count() / static_cast<std::size_t>(ct.size[2]);
    for (std::size_t v = 0; v < plane; ++v) spec.pixels += static_cast<char>(ct.hu[plane * k + v]);
    if (plane % 2 != 0) spec.pixels += '\0';
    test::DicomBytes slice(test::DicomSlice(ct, k, spec));
    for (const auto& [element, value] :
         std::vector<std::pair<std::uint16_t, char>>{{0x100, '\10'}, {0x101, '\10'}, {0x102, '\7'}}) {
      slice.Set(0x28, element, "US", {value, '\0'});
    }
    test::WriteBytes(folder.file(fmt::format("{:03}.dcm", k)), slice.File());
  }
  ImportReport report;
  EXPECT_EQ(ReadCt(folder.path(), {}, report).hu, ct.hu);
  EXPECT_THAT(test::MessageOf([&] { Import(folder.path(), {}); }),
              HasSubstr("these values are not HU: air lies near 0, soft tissue near 8"));
}

// The jaw with values mapped through points that join lines, from JawHu(): soft tissue of 40, bone of 900, teeth of
// 2000.
Volume MapJaw(double soft, double bone, double tooth) {
  Volume ct = test::JawCt(2);
  const auto map = [](double x, double from, double to, double a, double b) {
    return a + (x - from) / (to - from) * (b - a);
  };
  for (std::int16_t& value : ct.hu) {
    const double hu = value < 40    ? map(value, -1000, 40, -1000, soft)
                      : value < 900 ? map(value, 40, 900, soft, bone)
                                    : map(value, 900, 2000, bone, tooth);
    value = static_cast<std::int16_t>(std::lround(hu));
  }
  return ct;
}

// Fat is taken as soft tissue of 40, so that cortical bone of 1650 gets 1930.
TEST(GreyValues, ThresholdOfEnamelIsRaisedAboveCorticalBone) {
  Volume ct = MapJaw(-60, 1650, 2800);
  for (std::int16_t& value : ct.hu) value = static_cast<std::int16_t>(std::lround(300 + 0.6 * (value + 1000)));
  const ImportReport report = ImportJaw(ct, 0, true);
  EXPECT_TRUE(report.mandible);
  EXPECT_THAT(report.warnings, Contains(HasSubstr("most of it cortical bone: the threshold was raised to ")));
  EXPECT_GT(report.tooth_mm3, 0.03 * report.solid_mm3);
  EXPECT_LT(report.tooth_mm3, 0.3 * report.solid_mm3);
}

TEST(GreyValues, DenseBoneOfACtIsNotTakenAsEnamelWithoutAWord) {
  EXPECT_THAT(ImportJaw(MapJaw(40, 900, 2000), 300, false).warnings, Not(Contains(HasSubstr("for enamel"))));
  Volume ct = MapJaw(40, 900, 2800);
  for (std::size_t v = 0; v < ct.hu.size(); ++v) {  // a part of the right side
    if (v % 64 < 22 && ct.hu[v] > 850 && ct.hu[v] < 950) ct.hu[v] = 1850;
  }
  EXPECT_THAT(ImportJaw(ct, 300, false).warnings,
              Contains(HasSubstr("most of it probably cortical bone; --tooth-hu 1900 would leave ")));
}

// Without air, nothing else shows it.
TEST(GreyValues, MandibleThatWouldBeAllTeethIsRefused) {
  Volume ct = GreyJaw(2, -2000);
  for (std::int16_t& value : ct.hu) value = std::max<std::int16_t>(value, -200);
  EXPECT_THAT(MessageOf([&] { ImportJaw(ct, 300, false); }),
              HasSubstr("the values look like HU times a factor, such as 2"));
}

TEST(GreyValues, ToothThresholdsFollowAnIsoThatNothingElseExplains) {
  // Without air in the scan, its scale is unknown.
  Volume ct = GreyJaw(3, 0);
  for (std::int16_t& value : ct.hu) value = std::max<std::int16_t>(value, 3100);
  const ImportReport report = ImportJaw(ct, 3900, false);
  EXPECT_TRUE(report.mandible);
  EXPECT_GT(report.tooth_mm3, 0);
  EXPECT_LT(report.tooth_mm3, 0.3 * report.solid_mm3);
}

}  // namespace
}  // namespace kerf
