// Tests of kerf loop and run --record, kerf replay and kerf log as a user runs them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <sstream>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::MakeBlockScene;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;

class ReplayCommand : public test::ProgramTest {
 protected:
  ReplayCommand() : ProgramTest({{"s.toml", MakeBlockScene()}}) {}
  static void ExpectFailure(const ProgramResult& result, const std::string& part) {
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, HasSubstr(part));
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
    EXPECT_EQ(result.out, "");
  }
  void Record(const std::string& more = "") {
    const ProgramResult made = Kerf("loop s.toml --virtual --seconds 3 --record a.kerf " + more);
    ASSERT_EQ(made.code, 0) << made.err;
  }
};

TEST_F(ReplayCommand, VerifiesAndWritesTheSameResultsAsTheRun) {
  Record("-o out");
  const ProgramResult replayed = Kerf("replay a.kerf --verify --json -o again");
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const auto json = nlohmann::json::parse(replayed.out);
  EXPECT_TRUE(json.at("identical"));
  EXPECT_EQ(json.at("replayed_ticks"), 3000);
  EXPECT_EQ(json.at("bone_hash"), json.at("recorded_bone_hash"));
  const auto first = nlohmann::json::parse(Slurp(folder_ / "out/loop.json"));
  const auto second = nlohmann::json::parse(Slurp(folder_ / "again/loop.json"));
  EXPECT_EQ(first.at("bone_hash"), second.at("bone_hash"));
  EXPECT_EQ(first.at("force_hash"), second.at("force_hash"));
  EXPECT_EQ(first.at("recording").at("ticks"), 3000);
  // All rows are equal, because without the clock the ticks have no duration in either run.
  EXPECT_EQ(Slurp(folder_ / "out/forces.csv"), Slurp(folder_ / "again/forces.csv"));

  const ProgramResult part = Kerf("replay a.kerf --until 1.5 --json");
  EXPECT_EQ(nlohmann::json::parse(part.out).at("replayed_ticks"), 1500);
}

// The scene has no sections [loop] and [hand].
TEST_F(ReplayCommand, RateAndHandOfTheCommandLineAreRecorded) {
  Record("--rate-hz 2000 --hand H1");
  const ProgramResult replayed = Kerf("replay a.kerf --verify --json");
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(nlohmann::json::parse(replayed.out).at("replayed_ticks"), 6000);
}

TEST_F(ReplayCommand, RunAlongAPath) {
  ASSERT_EQ(Kerf("run s.toml -o out --record a.kerf").code, 0);
  ASSERT_EQ(Kerf("replay a.kerf --verify -o again").code, 0);
  EXPECT_EQ(Slurp(folder_ / "out/forces.csv"), Slurp(folder_ / "again/forces.csv"));
  ExpectFailure(Kerf("loop --from a.kerf"), "can't be resumed");
}

TEST_F(ReplayCommand, LogIsReadableAndHasCsv) {
  Record("--do 1:checkpoint=first");
  const ProgramResult shown = Kerf("log a.kerf");
  EXPECT_EQ(shown.code, 0);
  EXPECT_THAT(shown.out, HasSubstr("checkpoint first"));
  EXPECT_THAT(shown.out, HasSubstr("3000 ticks"));
  const auto count_lines = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  const ProgramResult csv = Kerf("log a.kerf --csv");
  EXPECT_EQ(count_lines(csv.out), 301);
  EXPECT_THAT(csv.out, HasSubstr("force_x_N"));
  ASSERT_EQ(Kerf("log a.kerf --csv --ticks -o ticks.csv").code, 0);
  EXPECT_EQ(count_lines(Slurp(folder_ / "ticks.csv")), 3001);
}

TEST_F(ReplayCommand, ContinuesAndUndoes) {
  Record("--do 1:checkpoint=first --do 2:undo=first");
  const ProgramResult further =
      Kerf("loop --from a.kerf --at 2.5 --virtual --seconds 0.5 --record b.kerf --do 2.7:undo=first --json");
  ASSERT_EQ(further.code, 0) << further.err;
  const auto json = nlohmann::json::parse(further.out);
  EXPECT_EQ(json.at("undo").at("restores"), 2);
  EXPECT_EQ(json.at("recording").at("ticks"), 3000);
  EXPECT_EQ(Kerf("replay b.kerf --verify").code, 0);
}

TEST_F(ReplayCommand, ExistingFilesAreNeverReplaced) {
  Record();
  const std::string before = Slurp(folder_ / "a.kerf");
  ExpectFailure(Kerf("loop s.toml --virtual --seconds 1 --record a.kerf"), "never replaces");
  ExpectFailure(Kerf("loop s.toml --virtual --seconds 1 --record s.toml"), "s.toml");
  ExpectFailure(Kerf("loop s.toml --virtual --seconds 1 --record none/b.kerf"), "no folder");
  ExpectFailure(Kerf("log a.kerf --csv -o a.kerf"), "a.kerf");
  // A result must not overwrite the recording either.
  std::filesystem::create_directory(folder_ / "o");
  ExpectFailure(Kerf("loop s.toml --virtual --seconds 1 -o o --record o/forces.csv"), "forces.csv");
  ExpectFailure(Kerf("run s.toml -o o --record o/bone.vdb"), "bone.vdb");
  EXPECT_EQ(Slurp(folder_ / "a.kerf"), before);
  EXPECT_EQ(Slurp(folder_ / "s.toml"), MakeBlockScene());
}

TEST_F(ReplayCommand, InvalidInputGivesOneSentence) {
  Record();
  Write("text.kerf", "hello");
  ExpectFailure(Kerf("replay text.kerf"), "is not a kerf recording");
  ExpectFailure(Kerf("replay none.kerf"), "no such file");
  ExpectFailure(Kerf("replay ."), "not a regular file");
  ExpectFailure(Kerf("loop --from a.kerf --at 99"), "3.000 s long");
  EXPECT_EQ(Kerf("loop s.toml --do nonsense").code, 2);
  EXPECT_EQ(Kerf("loop --from a.kerf --rate-hz 500").code, 2);
  ExpectFailure(Kerf("replay a.kerf --until 99"), "3.000 s long");
  EXPECT_EQ(Kerf("loop").code, 2);
  EXPECT_EQ(Kerf("loop s.toml --from a.kerf").code, 2);
  EXPECT_EQ(Kerf("log a.kerf --ticks").code, 2);
  // The complete part of a truncated recording is read, with a warning.
  const std::string bytes = Slurp(folder_ / "a.kerf");
  Write("short.kerf", bytes.substr(0, bytes.size() / 2));
  const ProgramResult part = Kerf("replay short.kerf --verify --json");
  EXPECT_EQ(part.code, 3);
  EXPECT_THAT(part.err, HasSubstr("cut short"));
  EXPECT_GT(nlohmann::json::parse(part.out).at("replayed_ticks"), 250);
}

TEST_F(ReplayCommand, AnotherBoneIsRefused) {
  ASSERT_EQ(Kerf("model block -o bone.vdb --size 6,4,3 --voxel 0.25").code, 0);
  std::string scene = MakeBlockScene();
  scene.replace(0, scene.find("[tool]"), "[bone]\nfile = \"bone.vdb\"\n");
  Write("s.toml", scene);
  Record();
  EXPECT_EQ(Kerf("replay a.kerf --verify").code, 0);
  ASSERT_EQ(Kerf("model block -o other.vdb --size 6,4,3.5 --voxel 0.25").code, 0);
  ExpectFailure(Kerf("replay a.kerf --bone other.vdb"), "is not the one");
  std::filesystem::rename(folder_ / "bone.vdb", folder_ / "moved.vdb");
  ExpectFailure(Kerf("replay a.kerf"), "--bone FILE");
  EXPECT_EQ(Kerf("replay a.kerf --verify --bone moved.vdb").code, 0);
}

// A file size limit of 16 blocks of 512 or 1024 bytes simulates a full disk.
TEST_F(ReplayCommand, FullDiskLosesOnlyTheRecording) {
  const ProgramResult made = KerfWithin("ulimit -f 16;", "loop s.toml --virtual --seconds 20 --record a.kerf");
  EXPECT_EQ(made.code, 1);
  EXPECT_THAT(made.err, HasSubstr("can't be written any further"));
  EXPECT_THAT(made.out, HasSubstr("removed"));
  const ProgramResult replayed = Kerf("replay a.kerf --verify --json");
  EXPECT_EQ(replayed.code, 3) << replayed.err;
  EXPECT_THAT(replayed.err, HasSubstr("cut short"));
}

}  // namespace
}  // namespace kerf
