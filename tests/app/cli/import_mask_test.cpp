// Tests `kerf import --mask`: what it prints, and invalid use.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::AllOf;
using testing::HasSubstr;

class ImportMask : public test::ProgramTest {
 protected:
  // Writes a CT of two balls of 9 mm that touch, and label maps of them: with names and without.
  void WriteBalls() const {
    constexpr int kWidth = 46, kSide = 26;
    std::string voxels, labels;
    for (int k = 0; k < kSide; ++k) {
      for (int j = 0; j < kSide; ++j) {
        for (int i = 0; i < kWidth; ++i) {
          const double a = std::hypot(i - 13.6, j - 12.2, k - 12.9), b = std::hypot(i - 31, j - 12.4, k - 12.6);
          const auto hu = static_cast<std::int16_t>(1000 / (1 + std::exp(4 * (std::min(a, b) - 9))));
          voxels.append(reinterpret_cast<const char*>(&hu), sizeof hu);
          labels += static_cast<char>(std::min(a, b) > 9 ? 0 : a < b ? 2 : 1);
        }
      }
    }
    const std::string lattice = fmt::format(
        "dimension: 3\nspace: left-posterior-superior\nsizes: {0} {1} {1}\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n"
        "endian: little\nencoding: raw\nspace origin: (0,0,0)\n",
        kWidth, kSide);
    Write("ct.nrrd", "NRRD0004\ntype: short\n" + lattice + "\n" + voxels);
    Write("bare.nrrd", "NRRD0004\ntype: uchar\n" + lattice + "\n" + labels);
    Write("named.seg.nrrd", "NRRD0004\ntype: uchar\n" + lattice +
                                "Segment0_Name:=Maxilla\nSegment0_LabelValue:=1\nSegment0_Layer:=0\n"
                                "Segment1_Name:=Mandible\nSegment1_LabelValue:=2\nSegment1_Layer:=0\n\n" +
                                labels);
  }
};

TEST_F(ImportMask, ImportsTheNamedBoneWithAndWithoutACt) {
  WriteBalls();
  const ProgramResult with = Kerf("import ct.nrrd --mask named.seg.nrrd --voxel 0.5 --iso 500 --json -o a.vdb");
  ASSERT_EQ(with.code, 0) << with.err;
  const auto json = nlohmann::json::parse(with.out);
  EXPECT_NEAR(json["volume_mm3"], 3053.6, 100);  // of a ball of 9 mm; the balls touch in a point
  EXPECT_EQ(json["mask"]["reach_mm"], 2);
  EXPECT_EQ(json["mask"]["segments"][0]["role"], "other");
  EXPECT_EQ(json["mask"]["segments"][1]["role"], "mandible");
  EXPECT_EQ(json["isolation"], "mask: 'Mandible', where it and the CT differ by more than 2 mm");
  EXPECT_THAT(Kerf("info a.vdb").out, HasSubstr("import_mask"));
  // A label and a preset say the same as the names.
  for (const char* labels : {"--label 2=mandible --label 1=other", "--labels dentalsegmentator"}) {
    const ProgramResult same =
        Kerf(fmt::format("import ct.nrrd --mask bare.nrrd {} --voxel 0.5 --iso 500 --json -o a.vdb", labels));
    ASSERT_EQ(same.code, 0) << same.err;
    EXPECT_EQ(nlohmann::json::parse(same.out)["volume_mm3"], json["volume_mm3"]) << labels;
  }
  const ProgramResult alone = Kerf("import --mask named.seg.nrrd --voxel 0.5 -o b.vdb");
  ASSERT_EQ(alone.code, 0) << alone.err;
  EXPECT_THAT(alone.out, HasSubstr("mask       3.0"));
  EXPECT_THAT(alone.err, HasSubstr("made without a CT: the surface is that of the segmentation"));
}

TEST_F(ImportMask, InvalidUseIsExplained) {
  WriteBalls();
  const ProgramResult bare = Kerf("import ct.nrrd --mask bare.nrrd -o a.vdb");
  EXPECT_EQ(bare.code, 1);
  EXPECT_THAT(bare.err, AllOf(HasSubstr("does not say what its labels are. They are:\n  label 1 ("),
                              HasSubstr("No preset of --labels fits; of the nearest, ")));
  const auto usage = [this](const std::string& arguments) {
    const ProgramResult result = Kerf("import " + arguments + " -o a.vdb");
    EXPECT_EQ(result.code, 2) << arguments;
    return result.err;
  };
  EXPECT_THAT(usage("--voxel 0.5"), HasSubstr("INPUT is required"));
  EXPECT_THAT(usage("ct.nrrd --label 2=mandible"), HasSubstr("--label: applies to a mask only; name one with --mask"));
  EXPECT_THAT(usage("--mask bare.nrrd --iso 500"), HasSubstr("--iso: does not apply to a mask without a CT"));
  EXPECT_THAT(usage("ct.nrrd --mask bare.nrrd --no-isolate"), HasSubstr("--no-isolate: imports all bone"));
  EXPECT_THAT(usage("ct.nrrd --mask ''"), HasSubstr("--mask: must not be empty"));
  EXPECT_THAT(usage("--mask bare.nrrd --label 1=foo"), HasSubstr("'foo' is no role"));
  EXPECT_THAT(usage("--mask bare.nrrd --label metal"), HasSubstr("should be LABEL=ROLE"));
  EXPECT_THAT(usage("ct.stl --mask bare.nrrd"), HasSubstr("--mask: applies to a CT only"));
  const auto refusal = [&](const std::string& mask) {
    const ProgramResult result = Kerf(fmt::format("import ct.nrrd --mask {} -o a.vdb", mask));
    EXPECT_EQ(result.code, 1) << mask;
    return result.err;
  };
  Write("empty.dcm", "");
  Write("text.dcm", std::string(500, 'x'));
  Write("text.doc", "x");
  EXPECT_THAT(refusal("none.dcm"), HasSubstr("none.dcm: there is no such file"));
  EXPECT_THAT(refusal("."), HasSubstr("is a folder, not a file"));
  EXPECT_THAT(refusal("empty.dcm"), HasSubstr("empty.dcm: not a DICOM file despite its name"));
  EXPECT_THAT(refusal("text.dcm"), HasSubstr("text.dcm: not a DICOM file despite its name"));
  const auto input = [&](const std::string& arguments) {
    const ProgramResult result = Kerf(arguments);
    EXPECT_EQ(result.code, 1) << arguments;
    EXPECT_THAT(result.err, HasSubstr("--mask")) << arguments;
  };
  input("import named.seg.nrrd -o a.vdb");
  input("import bare.nrrd -o a.vdb");
  input("picture named.seg.nrrd -o a.png");
  EXPECT_THAT(refusal("text.doc"), HasSubstr("a segmentation is a DICOM segmentation, a .seg.nrrd"));
}

}  // namespace
}  // namespace kerf
