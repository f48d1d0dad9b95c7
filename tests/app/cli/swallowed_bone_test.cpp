// Tests of a disc that is set down over the whole bone, so that no bone is left to draw.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A block of 6 x 1 x 6 mm below the origin is inside a disc that has a diameter of 22 mm and is 3 mm thick.
const std::string kSwallowedBoneScene =
    test::BlockToml({6, 1, 6}, 0.1) +
    "[force]\nlaw = \"hertz_chip\"\n[tool]\ndiameter_mm = 22.0\nthickness_mm = 3.0\n" +
    test::StrokeToml({0, 0, 0}, {0, 0, -0.4}, 4, {0, 1, 0});
constexpr char kNotDrawn[] = "no bone is left to draw: after.png is not written";

class SwallowedBone : public test::ProgramTest {
 protected:
  SwallowedBone() : ProgramTest({{"s.toml", kSwallowedBoneScene}}) {}
  /// Expects all results except those that show the bone after the cut, and warnings about them.
  void ExpectResults(const std::string& folder, const std::string& summary) const {
    ASSERT_TRUE(Exists(folder + "/" + summary));
    const auto json = nlohmann::json::parse(test::Slurp(folder_ / folder / summary));
    EXPECT_THAT(json.at("warnings").get<std::vector<std::string>>(),
                ElementsAre(HasSubstr("was set down inside the bone"), kNotDrawn));
    EXPECT_TRUE(json.at("cutting").at("specific_energy_J_per_mm3").is_null());
    const auto files = json.at("files").get<std::vector<std::string>>();
    for (const char* file : {"scene.toml", "forces.csv", "bone.vdb", "before.png"}) {
      EXPECT_THAT(files, Contains(file));
      EXPECT_TRUE(Exists(folder + "/" + file)) << file;
    }
    EXPECT_THAT(files, Not(Contains("after.png")));
    EXPECT_FALSE(Exists(folder + "/after.png"));
  }
};

TEST_F(SwallowedBone, RunAndReplayWriteAllOtherResults) {
  const ProgramResult run = Kerf("run s.toml -o o --record a.kerf");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr(std::string("kerf: warning: ") + kNotDrawn));
  // The volume is 6 x 1 x 6 mm3, less the edges: 52 mm, rounded by some tenths of h^2.
  const auto json = nlohmann::json::parse(test::Slurp(folder_ / "o/summary.json"));
  EXPECT_NEAR(json.at("removed").at("total_mm3").get<double>(), 36, 52 * 0.3 * 0.1 * 0.1);
  EXPECT_EQ(json.at("bone").at("volume_after_mm3"), 0);
  ExpectResults("o", "summary.json");
  const ProgramResult replay = Kerf("replay a.kerf -o again");
  EXPECT_EQ(replay.code, 0) << replay.err;
  ExpectResults("again", "summary.json");
}

TEST_F(SwallowedBone, LoopAndReplayWriteAllOtherResults) {
  const ProgramResult loop = Kerf("loop s.toml --virtual --seconds 0.1 -o o --record a.kerf");
  EXPECT_EQ(loop.code, 0) << loop.err;
  EXPECT_THAT(loop.err, HasSubstr(std::string("kerf: warning: ") + kNotDrawn));
  ExpectResults("o", "loop.json");
  EXPECT_THAT(test::Slurp(folder_ / "o/report.md"), HasSubstr(kNotDrawn));
  const ProgramResult replay = Kerf("replay a.kerf -o again");
  EXPECT_EQ(replay.code, 0) << replay.err;
  EXPECT_TRUE(Exists("again/bone.vdb"));
  EXPECT_THAT(test::Slurp(folder_ / "again/report.md"), HasSubstr(kNotDrawn));
}

// A picture of an earlier run must not be mistaken for one of this run.
TEST_F(SwallowedBone, PictureOfAnEarlierRunIsRemoved) {
  std::string other = kSwallowedBoneScene;
  other.replace(other.find("diameter_mm = 22.0"), 18, "diameter_mm = 2.0");
  Write("other.toml", other);
  ASSERT_EQ(Kerf("run other.toml -o o").code, 0);
  ASSERT_TRUE(Exists("o/after.png"));
  ASSERT_EQ(Kerf("run s.toml -o o").code, 0);
  EXPECT_FALSE(Exists("o/after.png"));
}

}  // namespace
}  // namespace kerf
