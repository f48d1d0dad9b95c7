// kerf tune as a user runs it: what it refuses, and that it writes only what it has shown to keep what was asked.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using ::testing::HasSubstr;

// A small block, and coarse voxels to try: half a second of work.
constexpr char kScene[] =
    "# mine\n[bone]\nmodel = \"block\"\n[bone.block]\nsize_x_mm = 6.0\nsize_y_mm = 4.0\nsize_z_mm = 3.0\n"
    "voxel_mm = 0.4  # coarse\n"
    "[tool]\ndiameter_mm = 12.0\nthickness_mm = 0.5\nteeth = 16\n"
    "[[path.stroke]]\nstart_mm = [0.0, 0.0, 6.5]\nend_mm = [0.0, 0.0, 5.0]\nfeed_mm_per_s = 6.0\n"
    "disc_normal = [1.0, 0.0, 0.0]\n";
constexpr char kQuick[] = " --led --seconds 0.2 --ticks 1000 --voxels 0.4,0.3";

class Tune : public test::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    Write("s.toml", kScene);
  }
  std::string Scene() const { return test::Slurp(folder_ / "s.toml"); }
};

TEST_F(Tune, RefusesWhatIsNoBound) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "give --budget-us, --error, or both"},
      {"--error much", "'much' is no share: give 3.5% or 0.035"},
      {"--error 3.5%%", "'3.5%%' is no share: give 3.5% or 0.035"},
      {"--error 0.001%", "'0.001%' is out of range; valid range 0.01% to 100%"},
      {"--error 2", "'2' is out of range; valid range 0.01% to 100%"},
      {"--budget-us 0", "0 us is out of range"},
  };
  for (const auto& [options, message] : cases) {
    const ProgramResult result = Kerf(std::string("tune s.toml ") + options);
    EXPECT_EQ(result.code, 2) << options;
    EXPECT_THAT(result.err, HasSubstr(message)) << options;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_EQ(Scene(), kScene);
  EXPECT_FALSE(Exists("s.tune.json"));
}

TEST_F(Tune, DryRunLeavesTheSceneAsItWas) {
  const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000 --dry-run") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("chosen"));
  EXPECT_EQ(Scene(), kScene);
  EXPECT_FALSE(Exists("s.tune.json"));
}

TEST_F(Tune, WritesTheSettingsIntoTheSceneAndTheEvidenceBesideIt) {
  const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  const std::string scene = Scene();
  EXPECT_THAT(scene, HasSubstr("# mine\n"));  // what is not chosen stays, comments too
  EXPECT_THAT(scene, HasSubstr("kerf tune"));
  EXPECT_EQ(Kerf("check s.toml").code, 0);
  const auto evidence = nlohmann::json::parse(test::Slurp(folder_ / "s.tune.json"));
  EXPECT_GE(evidence.at("candidates").size(), 2u);
  EXPECT_TRUE(evidence.contains("machine"));
}

TEST_F(Tune, ABoundThatNothingKeepsIsAFailureAndLeavesTheSceneAsItWas) {
  // No voxel of 0.3 mm and more is as exact as a hundredth of a per cent.
  const ProgramResult result = Kerf(std::string("tune s.toml --error 0.01% --budget-us 1") + kQuick);
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("the scene is as it was"));
  EXPECT_EQ(Scene(), kScene);
  EXPECT_FALSE(Exists("s.tune.json"));
}

}  // namespace
}  // namespace kerf
