// Tests that a result that cannot be written does not prevent the others, and that no picture is made of incomplete
// data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf::test {
namespace {

using testing::HasSubstr;
using testing::Not;

class LostResult : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
    Write("s.toml", MakeBlockScene({6.5, 4.5, 6}, ""));
  }
  ProgramResult Loop(const std::string& folder) const {
    return Kerf("loop s.toml --virtual --seconds 0.6 -o " + folder);
  }
};

TEST_F(LostResult, PieceThatCannotBeWrittenIsStillDrawn) {
  ASSERT_EQ(Loop("whole").code, 0);
  std::filesystem::create_directories(folder_ / "lost/piece_1.stl");
  const ProgramResult lost = Loop("lost");
  EXPECT_EQ(lost.code, 1);
  EXPECT_EQ(lost.err, "kerf: lost/piece_1.stl: can't be written: it is a folder\n");
  for (const char* picture : {"after.png", "cut.png"}) {
    EXPECT_EQ(Slurp(folder_ / "lost" / picture), Slurp(folder_ / "whole" / picture)) << picture;
  }
}

TEST_F(LostResult, PictureThatCannotBeWrittenDoesNotPreventTheOthers) {
  std::filesystem::create_directories(folder_ / "out/after.png");
  const ProgramResult lost = Loop("out");
  EXPECT_EQ(lost.code, 1);
  EXPECT_EQ(lost.err, "kerf: out/after.png: can't be written: it is a folder\n");
  const auto files = nlohmann::json::parse(Slurp(folder_ / "out/loop.json"))["files"];
  for (const char* name : {"before.png", "cut.png", "piece_1.stl"}) {
    EXPECT_TRUE(Exists(std::string("out/") + name)) << name;
    EXPECT_NE(std::find(files.begin(), files.end(), name), files.end()) << name;
  }
  EXPECT_EQ(std::find(files.begin(), files.end(), "after.png"), files.end());
  EXPECT_THAT(Slurp(folder_ / "out/report.md"), Not(HasSubstr("after.png")));
}

TEST_F(LostResult, WithoutADriverAllButPicturesIsWritten) {
  for (const char* command : {"run s.toml -o run", "loop s.toml --virtual --seconds 0.6 -o loop"}) {
    const ProgramResult result = KerfWithin("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent", command);
    EXPECT_EQ(result.code, 0) << command;
    EXPECT_THAT(result.err, HasSubstr("No pictures: this machine has no OpenGL driver")) << command;
  }
  for (const std::string folder : {"run/", "loop/"}) {
    for (const char* name : {"forces.csv", "bone.vdb", "piece_1.stl"}) EXPECT_TRUE(Exists(folder + name)) << folder;
    for (const char* name : {"before.png", "force.png"}) EXPECT_FALSE(Exists(folder + name)) << folder;
  }
  // A report with figures is refused before anything is computed.
  const ProgramResult result = KerfWithin("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent", "compare s.toml -o compare");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err,
              HasSubstr("nothing was computed, because the report has figures. No pictures: this machine has"));
  EXPECT_FALSE(Exists("compare/compare.csv"));
}

/// The test uses one core, because each thread takes address space. Without memory, Mesa's driver ends the program or
/// crashes, so drawing requires some free memory.
TEST_F(LostResult, LackOfMemoryForDrawingIsReported) {
  ASSERT_EQ(Kerf("model block --size 6,4,3 --voxel 0.25 -o b.vdb").code, 0);
  for (const int kB : {200000, 300000, 450000, 600000, 700000, 800000, 900000, 1000000}) {
    const ProgramResult result =
        KerfWithin("ulimit -v " + std::to_string(kB) + "; taskset -c 0", "picture b.vdb -o p.png --size 400x300");
    EXPECT_EQ(result.code, 1) << kB;
    EXPECT_THAT(result.err, testing::StartsWith("kerf: ")) << kB;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << kB << ": " << result.err;
    EXPECT_FALSE(Exists("p.png"));
  }
}

}  // namespace
}  // namespace kerf::test
