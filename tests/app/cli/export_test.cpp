// Tests of kerf export and kerf picture, run as programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bone/import/ct_files.h"
#include "bone/import/dicom_bytes.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;
using testing::Not;

class Export : public test::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    ASSERT_EQ(Kerf("model block --size 12,8,6 --layer 2:24 --layer 4:32 -o block.vdb").code, 0);
  }
};

TEST_F(Export, WholeSurfaceIsClosedAndHasTheBlocksVolume) {
  for (const char* format : {"stl", "obj", "ply"}) {
    const ProgramResult result = Kerf(std::string("export block.vdb --json -o block.") + format);
    ASSERT_EQ(result.code, 0) << result.err;
    const auto surface = nlohmann::json::parse(result.out)["surfaces"].at(0);
    EXPECT_TRUE(surface["closed"].get<bool>());
    // The surface's points are means over a voxel, which bevels sharp edges by less than a voxel: by less than 0.2^2
    // mm2 along 104 mm.
    EXPECT_LT(surface["volume_mm3"].get<double>(), 576);
    EXPECT_GT(surface["volume_mm3"].get<double>(), 576 - 0.04 * 104);
    EXPECT_EQ(surface["triangles"], surface["triangles_before_reduction"]);
    EXPECT_TRUE(Exists(std::string("block.") + format));
  }
}

TEST_F(Export, ReducedSurfaceHasTheRequestedTrianglesWithinAVoxel) {
  const ProgramResult result = Kerf("export block.vdb --triangles 400 --json -o block.stl");
  ASSERT_EQ(result.code, 0) << result.err;
  const auto surface = nlohmann::json::parse(result.out)["surfaces"].at(0);
  EXPECT_LE(surface["triangles"].get<int>(), 400);
  EXPECT_GT(surface["triangles_before_reduction"].get<int>(), 10000);
  EXPECT_TRUE(surface["closed"].get<bool>());
  EXPECT_LT(std::abs(surface["volume_change_percent"].get<double>()), 0.5);
  EXPECT_LT(surface["largest_deviation_mm"].get<double>(), 0.2);
  EXPECT_FALSE(surface["largest_deviation_is_lower_bound"].get<bool>());
  EXPECT_EQ(std::filesystem::file_size(folder_ / "block.stl"), 84u + 50u * surface["triangles"].get<unsigned>());
}

TEST_F(Export, EachPieceIsWrittenToASeparateFile) {
  const ProgramResult result = Kerf("export block.vdb --pieces --colour tissue -o part.ply");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("part-1.ply: "));
  EXPECT_TRUE(Exists("part-1.ply"));
  EXPECT_FALSE(Exists("part-2.ply"));
  ExpectRefusal(Kerf("export block.vdb --pieces --min-piece 1000 -o part.ply"),
                "block.vdb: has no piece of at least 1000 mm3; lower --min-piece");
}

TEST_F(Export, DicomSegmentationsReferToTheirCtAndNeverReplaceIt) {
  std::filesystem::create_directory(folder_ / "ct");
  const Volume ct = test::MakeCt(
      {12, 10, 8}, {2, 2, 2}, {-11, -9, -7}, glm::dmat3(1), [](const Vec3& p) { return glm::length(p) - 5; }, 900);
  test::WriteDicom(ct, (folder_ / "ct").string());
  const ProgramResult written = Kerf("export block.vdb --seg cut.dcm --ct ct");
  EXPECT_EQ(written.code, 0) << written.err;
  EXPECT_TRUE(Exists("cut.dcm"));
  const std::filesystem::path slice = *std::filesystem::directory_iterator(folder_ / "ct");
  const std::string before = test::Slurp(slice);
  const ProgramResult over = Kerf("export block.vdb --ct ct --seg ct/" + slice.filename().string());
  EXPECT_EQ(over.code, 1);
  EXPECT_THAT(over.err, HasSubstr("is an input and would be overwritten"));
  EXPECT_EQ(test::Slurp(slice), before);
  EXPECT_THAT(Kerf("export block.vdb --seg cut.dcm --ct block.vdb").err, HasSubstr("is not a folder of DICOM files"));
  EXPECT_EQ(Kerf("export block.vdb --seg cut.dcm").code, 2);
  test::SliceSpec spec;
  spec.modality = "MR";
  test::WriteDicom(ct, (folder_ / "ct").string(), spec);
  EXPECT_THAT(Kerf("export block.vdb --seg cut.dcm --ct ct").err, HasSubstr("the modality is MR, not CT"));
}

TEST_F(Export, ACtWithoutSpacingNeedsItForASegmentationToo) {
  const Volume ct = test::MakeCt(
      {12, 10, 8}, {2, 2, 2}, {-11, -9, -7}, glm::dmat3(1), [](const Vec3& p) { return glm::length(p) - 5; }, 900);
  test::SliceSpec spec;
  for (const std::int16_t hu : ct.hu) spec.pixels += {static_cast<char>(hu & 0xff), static_cast<char>(hu >> 8 & 0xff)};
  test::DicomBytes file(test::DicomSlice(ct, 0, spec));
  test::WriteBytes(folder_ / "ct.dcm", file.Set(0x28, 8, "IS", "8").Remove(0x18, 0x50).File());
  EXPECT_THAT(Kerf("export block.vdb --seg cut.dcm --ct ct.dcm").err, HasSubstr("state it in mm with --spacing-z"));
  const ProgramResult written = Kerf("export block.vdb --seg cut.dcm --ct ct.dcm --spacing-z 2");
  EXPECT_EQ(written.code, 0) << written.err;
  EXPECT_TRUE(Exists("cut.dcm"));
  EXPECT_EQ(Kerf("export block.vdb -o block.stl --spacing-z 2").code, 2);
  // What was assumed is said, as by kerf import; what the user states is not.
  const std::string assumed = "the frames were placed in their order along the normal of their plane";
  EXPECT_THAT(written.err, HasSubstr(assumed));
  for (const char* command : {"export block.vdb --seg cut.dcm --ct ", "import -o ct.vdb ", "picture -o ct.png "}) {
    EXPECT_THAT(Kerf(std::string(command) + "ct.dcm --spacing-z 2").err, HasSubstr(assumed)) << command;
    EXPECT_THAT(Kerf(std::string(command) + "ct.dcm --spacing-z 2 --frame LPS").err, Not(HasSubstr(assumed)));
    EXPECT_EQ(Kerf(std::string(command) + "ct.dcm --spacing-z 2 --frame LPX").code, 2);
  }
}

TEST_F(Export, ASeriesThatIsNotStatedToBeACtIsConfirmedForASegmentationAndAPicture) {
  std::filesystem::create_directory(folder_ / "ct");
  test::SliceSpec spec;
  spec.modality = "OT";
  test::WriteDicom(
      test::MakeCt(
          {12, 10, 8}, {2, 2, 2}, {-11, -9, -7}, glm::dmat3(1), [](const Vec3& p) { return glm::length(p) - 7; }, 900),
      (folder_ / "ct").string(), spec);
  for (const std::string command : {"export block.vdb --seg cut.dcm --ct ct", "picture ct -o ct.png"}) {
    const ProgramResult refused = Kerf(command);
    EXPECT_EQ(refused.code, 1);
    EXPECT_THAT(refused.err, HasSubstr("--as-ct"));
    const ProgramResult written = Kerf(command + " --as-ct");
    EXPECT_EQ(written.code, 0) << written.err;
    EXPECT_THAT(written.err, HasSubstr("it was read as a CT because of --as-ct"));
  }
  EXPECT_THAT(Kerf("picture block.vdb -o a.png --as-ct").err, HasSubstr("applies to CTs, but the input is a bone"));
}

TEST_F(Export, ATurnedFrameIsThatOfTheBone) {
  std::filesystem::create_directory(folder_ / "ct");
  // The slices lie at z = 2 to 18 mm of the file, and the bone, of which z is turned, at -6 to 0 mm of the patient.
  test::WriteDicom(test::MakeCt(
                       {12, 10, 8}, {2, 2, 2}, {-11, -9, 3}, glm::dmat3(1),
                       [](const Vec3& p) { return glm::length(p - Vec3(0, 0, 10)) - 7; }, 900),
                   (folder_ / "ct").string());
  EXPECT_THAT(Kerf("export block.vdb --seg cut.dcm --ct ct").err, HasSubstr("the bone is not inside"));
  EXPECT_EQ(Kerf("export block.vdb --seg cut.dcm --ct ct --frame LAI").code, 0);
  ASSERT_EQ(Kerf("import ct -o ball.vdb --no-isolate --frame LAI --voxel 0.5").code, 0);
  const ProgramResult known = Kerf("export ball.vdb --seg cut.dcm --ct ct");
  EXPECT_EQ(known.code, 0);
  EXPECT_THAT(known.err, HasSubstr("ct: its frame was taken as LAI, as when ball.vdb was imported"));
}

TEST_F(Export, PictureHasTheRequestedSize) {
  const ProgramResult result = Kerf("picture block.vdb --view front --colour region --size 320x200 -o block.png");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "block.png\n");
  const std::string png = test::Slurp(folder_ / "block.png");
  // Width and height are stored big-endian from byte 16 on.
  ASSERT_GT(png.size(), 24u);
  EXPECT_EQ(png.substr(16, 8), std::string("\0\0\x01\x40\0\0\0\xc8", 8));
}

TEST_F(Export, BadUsageAndBadFilesAreRefused) {
  ExpectRefusal(
      Kerf("export none.vdb -o a.stl"),
      "none.vdb: there is no such file; 'kerf import INPUT -o none.vdb' makes it from a CT or a closed surface");
  ExpectRefusal(Kerf("export block.vdb -o a.vtk"), "a.vtk: a surface's name must end in .stl, .obj or .ply");
  ExpectRefusal(Kerf("export block.vdb --colour tissue -o a.stl"), "a.stl: colours can only be written to a .ply");
  ExpectRefusal(Kerf("picture block.vdb -o a.jpg"), "a.jpg: the name of a picture must end in .png");
  for (const char* arguments :
       {"export block.vdb", "export block.vdb --triangles 3 -o a.stl", "picture block.vdb --size 3x -o a.png",
        "picture block.vdb --view behind -o a.png", "export block.vdb --colour red -o a.ply"}) {
    EXPECT_EQ(Kerf(arguments).code, 2) << arguments;
  }
  EXPECT_THAT(Kerf("picture block.vdb --size 3x -o a.png").err, HasSubstr("'3x' is not a size: give WIDTHxHEIGHT"));
}

}  // namespace
}  // namespace kerf
