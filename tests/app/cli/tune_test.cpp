// Tests of kerf tune as a user runs it: it refuses faulty requests, writes only settings that were shown to satisfy the
// request, and changes its input only on request.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::StartsWith;

// The block is small and the voxels are coarse, so that the work takes a second.
constexpr char kTuneScene[] =
    "# mine\n[bone]\nmodel = \"block\"\n[bone.block]\nsize_x_mm = 6.0\nsize_y_mm = 4.0\nsize_z_mm = 3.0\n"
    "voxel_mm = 0.4  # coarse\n"
    "[tool]\ndiameter_mm = 12.0\nthickness_mm = 0.5\nteeth = 16\n"
    "[[path.stroke]]\nstart_mm = [0.0, 0.0, 6.5]\nend_mm = [0.0, 0.0, 5.0]\nfeed_mm_per_s = 6.0\n"
    "disc_normal = [1.0, 0.0, 0.0]\n";
constexpr char kQuick[] = " --led --ticks 1000 --voxels 0.4,0.3";

class Tune : public test::ProgramTest {
 protected:
  Tune() : ProgramTest({{"s.toml", kTuneScene}}) {}
  std::string Scene() const { return test::Slurp(folder_ / "s.toml"); }
  /// Returns the names of all files except those with the output of Kerf().
  std::vector<std::string> Files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name != "stdout.txt" && name != "stderr.txt") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }
};

TEST_F(Tune, RefusesInvalidBounds) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "give --budget-us, --error, or both"},
      {"--error much", "'much' is not a fraction: give 3.5% or 0.035"},
      {"--error 3.5%%", "'3.5%%' is not a fraction: give 3.5% or 0.035"},
      {"--error 0.001%", "0.001% is below 0.01; valid range 0.01 to 100 %"},
      {"--error 2", "2 is above 100; valid range 0.01 to 100 %"},
      {"--budget-us 0", "0 is below 1; valid range 1 to 1000000 us"},
  };
  for (const auto& [options, message] : cases) {
    const ProgramResult result = Kerf(std::string("tune s.toml ") + options);
    EXPECT_EQ(result.code, 2) << options;
    EXPECT_THAT(result.err, HasSubstr(message)) << options;
    EXPECT_EQ(result.out, "");
  }
  EXPECT_EQ(Scene(), kTuneScene);
  EXPECT_FALSE(Exists("s.tune.json"));
}

TEST_F(Tune, DryRunDoesNotChangeTheScene) {
  const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000 --dry-run --in-place") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("chosen"));
  EXPECT_EQ(Scene(), kTuneScene);
  EXPECT_THAT(Files(), ElementsAre("s.toml"));
}

// Without -o and --in-place, only the scene goes to stdout, and no file is written.
TEST_F(Tune, PrintsTheSceneAndWritesNoFile) {
  const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("  chosen    requested p99 at most 1e+06 us"));
  EXPECT_THAT(result.out, StartsWith("# mine\n"));
  EXPECT_THAT(result.out, HasSubstr("# kerf tune: requested p99"));
  // The figure states its range. The block is as long as the path, 0.25 s.
  EXPECT_THAT(result.out, HasSubstr("over the whole path from the first contact onward (0.03 to 0.25 s)"));
  EXPECT_EQ(Scene(), kTuneScene);
  EXPECT_THAT(Files(), ElementsAre("s.toml"));
  Write("t.toml", result.out);
  EXPECT_EQ(Kerf("check t.toml").code, 0);
}

TEST_F(Tune, WritesTheSceneToAFileAndTheEvidenceBesideIt) {
  const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000 -o new.toml") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(Scene(), kTuneScene);
  EXPECT_THAT(Files(), ElementsAre("new.toml", "new.tune.json", "s.toml"));
  EXPECT_THAT(test::Slurp(folder_ / "new.toml"), HasSubstr("# kerf tune: "));
  EXPECT_EQ(Kerf("check new.toml").code, 0);
  const auto evidence = nlohmann::json::parse(test::Slurp(folder_ / "new.tune.json"));
  EXPECT_GE(evidence.at("candidates").size(), 2u);
  EXPECT_TRUE(evidence.contains("machine"));
  EXPECT_THAT(evidence.at("errors_over").get<std::string>(), HasSubstr("the whole path"));
  EXPECT_GE(evidence.at("phases").size(), 1u);
}

TEST_F(Tune, ChangesItsInputOnlyOnRequestAndKeepsABackup) {
  Write("s.toml.bak", "an earlier one");
  ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000 --in-place") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("  written   s.toml s.tune.json\n  backup    s.toml.bak.1, the original scene\n"));
  EXPECT_THAT(Files(), ElementsAre("s.toml", "s.toml.bak", "s.toml.bak.1", "s.tune.json"));
  EXPECT_EQ(test::Slurp(folder_ / "s.toml.bak"), "an earlier one");
  EXPECT_EQ(test::Slurp(folder_ / "s.toml.bak.1"), kTuneScene);
  EXPECT_THAT(Scene(), HasSubstr("# mine\n"));  // the rest is unchanged, including comments
  EXPECT_THAT(Scene(), HasSubstr("# kerf tune: "));
  EXPECT_EQ(Kerf("check s.toml").code, 0);
}

// The bound cannot be satisfied, so the message shows whether the outputs or the settings were tried first.
TEST_F(Tune, DetectsUnwritableOutputsBeforeMeasuring) {
  const std::string bounds = std::string(" --error 0.01% --budget-us 1") + kQuick;
  ProgramResult result = Kerf("tune s.toml -o /proc/tuned.toml" + bounds);  // no process can create a file there
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("/proc/tuned.toml: can't be written: "));
  // The name is short enough for the scene, but not for the files next to it.
  const std::string name = std::string(246, 'a') + ".toml";
  Write(name, kTuneScene);
  result = Kerf("tune " + name + " --in-place" + bounds);
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("can't be written: "));
  EXPECT_EQ(test::Slurp(folder_ / name), kTuneScene);
  EXPECT_THAT(Files(), ElementsAre(name, "s.toml"));
}

TEST_F(Tune, RefusesOutputThatIsItsInputUnderAnotherName) {
  std::filesystem::create_symlink("s.toml", folder_ / "link.toml");
  for (const char* name : {"s.toml", "./s.toml", "link.toml"}) {
    const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000 -o ") + name + kQuick);
    EXPECT_EQ(result.code, 1) << name;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, HasSubstr("-o is the scene itself; give --in-place to change it, with a backup"));
  }
  EXPECT_EQ(Kerf(std::string("tune s.toml --budget-us 1000000 --in-place -o new.toml") + kQuick).code, 2);
  EXPECT_EQ(Scene(), kTuneScene);
  EXPECT_THAT(Files(), ElementsAre("link.toml", "s.toml"));
}

TEST_F(Tune, StdoutIsOnlyJsonAndNamesTheChanges) {
  const ProgramResult result = Kerf(std::string("tune s.toml --budget-us 1000000 --json") + kQuick);
  ASSERT_EQ(result.code, 0) << result.err;
  const auto json = nlohmann::json::parse(result.out);
  ASSERT_FALSE(json.at("edits").empty());
  EXPECT_TRUE(json.at("edits")[0].contains("key"));
  EXPECT_THAT(Files(), ElementsAre("s.toml"));
}

TEST_F(Tune, UnsatisfiableBoundFailsAndDoesNotChangeTheScene) {
  // No voxel of 0.3 mm or more has an error as small as 0.01 %.
  const ProgramResult result = Kerf(std::string("tune s.toml --error 0.01% --budget-us 1 --in-place") + kQuick);
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("the scene is unchanged"));
  EXPECT_EQ(Scene(), kTuneScene);
  EXPECT_THAT(Files(), ElementsAre("s.toml"));
}

}  // namespace
}  // namespace kerf
