// Tests of kerf picture as a user runs it, for a CT that was not imported and for a bone.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <fstream>
#include <vector>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;

class PictureCommand : public test::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    WriteBall();
  }
  // Writes a ball of bone of 12 mm radius about (5, -20, 30), in voxels of 1 mm, surrounded by air.
  void WriteBall() const {
    WriteImage("ball.mha", 1200, -1000);
    WriteImage("mask.mha", 1, 0);
  }
  void WriteImage(const char* name, std::int16_t inside, std::int16_t outside) const {
    std::vector<std::int16_t> hu;
    for (int k = 0; k < 40; ++k) {
      for (int j = 0; j < 40; ++j) {
        for (int i = 0; i < 40; ++i) {
          const double d = std::hypot(i - 20, j - 20, k - 20);
          hu.push_back(d < 12 ? inside : outside);
        }
      }
    }
    std::ofstream file(folder_ / name, std::ios::binary);
    file << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nDimSize = 40 40 40\n"
            "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = -15 -40 10\nElementSpacing = 1 1 1\nElementType = "
            "MET_SHORT\nElementDataFile = LOCAL\n";
    file.write(reinterpret_cast<const char*>(hu.data()), static_cast<std::streamsize>(2 * hu.size()));
  }
  // Returns width and height from the PNG's header.
  std::pair<int, int> SizeOf(const std::string& name) const {
    const std::string bytes = test::Slurp(folder_ / name);
    const auto number = [&](std::size_t at) {
      int n = 0;
      for (std::size_t i = at; i < at + 4; ++i) n = 256 * n + static_cast<unsigned char>(bytes.at(i));
      return n;
    };
    return {number(16), number(20)};
  }
};

TEST_F(PictureCommand, AMaskIsDrawnOnItsCt) {
  const ProgramResult result =
      Kerf("picture ball.mha --mask mask.mha --label 1=mandible --slice z=30 -o mask.png --size 900x700");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(SizeOf("mask.png"), std::pair(900, 700));
  ASSERT_EQ(Kerf("picture ball.mha --slice z=30 -o plain.png --size 900x700").code, 0);
  EXPECT_NE(test::Slurp(folder_ / "mask.png"), test::Slurp(folder_ / "plain.png"));
  const ProgramResult bare = Kerf("picture ball.mha --label 1=mandible -o mask.png");
  EXPECT_EQ(bare.code, 2);
  EXPECT_THAT(bare.err, HasSubstr("applies to a mask only"));
  EXPECT_EQ(Kerf("picture ball.mha --mask mask.mha --label 1=mandible -o mask.mha").code, 1);
}

TEST_F(PictureCommand, ACtIsDrawnWithoutABone) {
  const ProgramResult result = Kerf("picture ball.mha --axes -o ct.png --size 900x700");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "ct.png\n");
  EXPECT_EQ(result.err, "");
  EXPECT_EQ(SizeOf("ct.png"), std::pair(900, 700));
  const ProgramResult slice =
      Kerf("picture ball.mha --slice z=30 --slice x=5 --keep 5,-20,30 -o slice.png --size 900x700");
  ASSERT_EQ(slice.code, 0) << slice.err;
  EXPECT_NE(test::Slurp(folder_ / "slice.png"), test::Slurp(folder_ / "ct.png"));
}

TEST_F(PictureCommand, BoneHasAxesOnlyOnRequest) {
  ASSERT_EQ(Kerf("model block --size 8,4,4 --voxel 0.4 -o b.vdb").code, 0);
  ASSERT_EQ(Kerf("picture b.vdb --view front -o plain.png").code, 0);
  ASSERT_EQ(Kerf("picture b.vdb --view front --axes -o axes.png").code, 0);
  EXPECT_EQ(SizeOf("axes.png"), std::pair(1280, 720));
  EXPECT_NE(test::Slurp(folder_ / "axes.png"), test::Slurp(folder_ / "plain.png"));
}

TEST_F(PictureCommand, RefusesInputThatCannotBeDrawn) {
  EXPECT_EQ(Kerf("picture ball.mha -o a.png --slice q=3").err,
            "kerf: --slice: 'q=3' must be x=MM, y=MM or z=MM; see 'kerf picture --help'\n");
  EXPECT_THAT(Kerf("picture ball.mha -o a.png --slice z=99").err,
              HasSubstr("z=99 is outside the bone, which extends from 14 mm to 46 mm"));
  EXPECT_EQ(Kerf("picture ball.mha -o a.png --slice z=30,31").code, 2);
  EXPECT_EQ(Kerf("picture ball.mha -o a.png --view front").code, 2);
  EXPECT_EQ(Kerf("picture ball.mha -o a.png --keep 1,2").code, 2);
  const ProgramResult small = Kerf("picture ball.mha -o a.png --size 64x64");
  EXPECT_EQ(small.code, 2);
  EXPECT_EQ(small.err,
            "kerf: --size: a CT is drawn in several pictures; give each side 200 to 8192 pixels; see 'kerf picture "
            "--help'\n");
  ASSERT_EQ(Kerf("model block --size 8,4,4 --voxel 0.4 -o b.vdb").code, 0);
  EXPECT_EQ(Kerf("picture b.vdb -o a.png --slice z=1").code, 2);
  ExpectRefusal(Kerf("picture ball.mha -o a.png --iso 2000"),
                "ball.mha: no bone: no piece above 2000 HU is 1 cm3 or larger; choose another value with --iso");
  WriteImage("mask.seg.nrrd", 1, 0);
  ExpectRefusal(Kerf("picture mask.seg.nrrd -o a.png"),
                "mask.seg.nrrd: a segmentation, not a CT; import it with --mask");
  EXPECT_FALSE(Exists("a.png"));
}

}  // namespace
}  // namespace kerf
