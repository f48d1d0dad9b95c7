// Tests of a disk with little space: the checks before the work, the results kept when the disk is full, and the order
// of messages.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <vector>

#include "support/block_scene.h"
#include "support/program.h"
#include "test_paths.h"

namespace kerf {
namespace {

using test::MakeBlockScene;
using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;

constexpr char kLittleSpaceMore[] = "[output]\npictures = false\nbone = false\npieces = false\n";

class LittleSpace : public test::ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    // The scenes take 0.8 s and 400 s.
    Write("short.toml", MakeBlockScene({.from_mm = 6.5, .feed_mm_per_s = 5}, kLittleSpaceMore));
    Write("long.toml", MakeBlockScene({.from_mm = 6.5, .feed_mm_per_s = 0.01}, kLittleSpaceMore));
    if (Within("mount -t tmpfs none m", "true").code != 0) GTEST_SKIP() << "no file system may be mounted here";
  }

  /// Runs `command` after `mount` in a separate mount namespace, with the folders m and n as mount points; their
  /// contents are then copied to m_after and n_after.
  ProgramResult Within(const std::string& mount, const std::string& command) const {
    Write("commands.sh", fmt::format("mkdir -p m n m_after n_after && {} || exit 99\n"
                                     "env -u DISPLAY {} >stdout.txt 2>stderr.txt </dev/null\n"
                                     "code=$?\ncp -a m/. m_after && cp -a n/. n_after || exit 99\nexit $code\n",
                                     mount, command));
    const int status =
        std::system(fmt::format("cd '{}' && unshare -m sh commands.sh 2>/dev/null", folder_.string()).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), Slurp(folder_ / "stdout.txt"),
            Slurp(folder_ / "stderr.txt")};
  }
  static std::string Mount(const char* name, int kB) {
    return fmt::format("mount -t tmpfs -o size={}k none {}", kB, name);
  }
  /// Returns the messages without the warnings.
  static std::vector<std::string> Sentences(const ProgramResult& result) {
    std::vector<std::string> sentences;
    std::istringstream lines(result.err);
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("kerf: warning: ")) sentences.push_back(line);
    }
    return sentences;
  }
  /// Returns the length of a recording from `kerf log`, s.
  double Seconds(const std::string& file) const {
    const std::string out = Kerf("log " + file + " --json").out;
    const std::string key = "\"duration_s\": ";
    const std::size_t at = out.find(key);
    return at == std::string::npos ? -1 : std::stod(out.substr(at + key.size()));
  }
};

// Each of the 400,000 ticks needs a row of at least 100 bytes, and 2 bytes in the recording.
TEST_F(LittleSpace, RunThatCannotFitIsRefusedBeforeItStarts) {
  const ProgramResult refused =
      Within(Mount("m", 2048), "'" KERF_PROGRAM "' run long.toml -o m/out --record m/session.kerf");
  EXPECT_EQ(refused.code, 1);
  EXPECT_THAT(Sentences(refused),
              testing::ElementsAre("kerf: m/session.kerf and m/out/forces.csv: can't be written: at least 40.8 MB are "
                                   "needed and 2.1 MB are free on the disk"));
  EXPECT_FALSE(Exists("m_after/session.kerf"));
  // The results are on separate disks: the recording alone would fit.
  const ProgramResult apart = Within(Mount("m", 2048) + " && " + Mount("n", 1024),
                                     "'" KERF_PROGRAM "' run long.toml -o m/out --record n/session.kerf");
  EXPECT_THAT(
      Sentences(apart),
      testing::ElementsAre("kerf: m/out/forces.csv: can't be written: at least 40.0 MB are needed and 2.1 MB are "
                           "free on the disk"));
  // With fewer rows, the results fit.
  Write("fewer.toml", Slurp(folder_ / "short.toml") + "forces_every_ticks = 10\n");
  EXPECT_EQ(Within(Mount("m", 512), "'" KERF_PROGRAM "' run fewer.toml -o m/out").code, 0);
}

TEST_F(LittleSpace, LoopThatMayNotFitRunsWithAWarning) {
  const ProgramResult warned =
      Within(Mount("m", 40), "'" KERF_PROGRAM "' loop short.toml --virtual --seconds 1 -o m/out");
  EXPECT_THAT(warned.err, HasSubstr("kerf: warning: m/out/forces.csv: can't be written: at least 100.0 kB are needed "
                                    "and 41.0 kB are free on the disk; the loop itself continues without this table"));
  EXPECT_THAT(Sentences(warned), testing::ElementsAre(HasSubstr("can't be written")));
  const ProgramResult fits =
      Within(Mount("m", 4096), "'" KERF_PROGRAM "' loop short.toml --virtual --seconds 1 -o m/out");
  EXPECT_EQ(fits.code, 0) << fits.err;
  EXPECT_THAT(fits.err, testing::Not(HasSubstr("can't be written")));
}

// forces.csv takes 2 MB in 10 s and the recording 60 kB. Without the space reserved for the recording the rows would
// fill the disk.
TEST_F(LittleSpace, RecordingHasPriorityOverTheRowsOfALoop) {
  const ProgramResult result = Within(
      Mount("m", 1800), "'" KERF_PROGRAM "' loop short.toml --virtual --seconds 10 -o m/out --record m/session.kerf");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(
      Sentences(result),
      testing::ElementsAre(
          "kerf: m/out/forces.csv: can't be written: the last 1.1 MB of the disk are reserved for the recording"));
  EXPECT_NEAR(Seconds("m_after/session.kerf"), 10, 1e-6);
  EXPECT_TRUE(Exists("m_after/out/loop.json"));
  EXPECT_FALSE(Exists("m_after/out/forces.csv"));
}

// The loop has 20,000 rows of at least 100 bytes, and 1.24 MB are reserved for the recording, which needs 40 kB. It is
// known beforehand that the rows do not fit and that the recording does.
TEST_F(LittleSpace, WarningBeforeALoopNamesTheFilesAtRisk) {
  const std::string loop = "'" KERF_PROGRAM "' loop short.toml --virtual --seconds 20 -o m/out --record m/session.kerf";
  const ProgramResult rows = Within(Mount("m", 2500), loop);
  EXPECT_THAT(
      rows.err,
      HasSubstr(
          "kerf: warning: m/out/forces.csv: can't be written: at least 3.2 MB are needed and 2.6 MB are free on the "
          "disk; 1.2 MB of it remain free for the recording; the loop and its recording continue without this "
          "table\n"));
  EXPECT_NEAR(Seconds("m_after/session.kerf"), 20, 1e-6);
  EXPECT_FALSE(Exists("m_after/out/forces.csv"));
  std::filesystem::remove_all(folder_ / "m_after");
  const ProgramResult recording = Within(Mount("m", 24), loop);
  EXPECT_THAT(recording.err,
              HasSubstr("kerf: warning: m/session.kerf: can't be written: at least 40.0 kB are needed and 24.6 kB are "
                        "free on the disk; the loop would end early, with its recording\n"));
  EXPECT_LT(Seconds("m_after/session.kerf"), 20);
}

// Neither the 10,000 rows of at least 100 bytes nor the picture of the force fit.
TEST_F(LittleSpace, LossOfTheRowsIsAlwaysReported) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  const std::string loop = "'" KERF_PROGRAM "' loop short.toml --virtual --seconds 10 -o m/out --record n/session.kerf";
  const ProgramResult lost = Within(Mount("m", 32) + " && " + Mount("n", 2048), loop);
  EXPECT_EQ(lost.code, 1);
  EXPECT_THAT(Sentences(lost),
              testing::ElementsAre(testing::AllOf(testing::StartsWith("kerf: m/out/forces.csv: can't be written: "),
                                                  testing::ContainsRegex("; also lost: .*force\\.png"))));
  EXPECT_FALSE(Exists("m_after/out/forces.csv"));
  EXPECT_FALSE(Exists("m_after/out/force.png"));
  EXPECT_TRUE(Exists("m_after/out/loop.json")) << "small files are still written";
  EXPECT_NEAR(Seconds("n_after/session.kerf"), 10, 1e-6);
  // Rows of an earlier loop must not remain next to results of this one.
  std::filesystem::remove_all(folder_ / "m_after");
  std::filesystem::remove_all(folder_ / "n_after");
  const std::string earlier = "'" KERF_PROGRAM "' loop short.toml --virtual --seconds 0.1 -o m/out >/dev/null 2>&1";
  const ProgramResult again =
      Within(Mount("m", 200) + " && " + Mount("n", 2048) + " && " + earlier + " && test -f m/out/forces.csv", loop);
  EXPECT_EQ(again.code, 1);
  EXPECT_THAT(Sentences(again),
              testing::ElementsAre(testing::StartsWith("kerf: m/out/forces.csv: can't be written: ")));
  EXPECT_FALSE(Exists("m_after/out/forces.csv"));
}

TEST_F(LittleSpace, FullDiskIsReportedForTheHistory) {
  for (const int kB : {4, 12, 24, 40}) {
    SCOPED_TRACE(kB);
    const ProgramResult full = Within(Mount("m", kB), "KERF_DATA=m '" KERF_PROGRAM "' practise --history");
    SkipIfNotBuilt(full);
    EXPECT_EQ(full.code, 1);
    EXPECT_THAT(Sentences(full), testing::ElementsAre("kerf: m/practise.db: can't be written: the disk is full"));
  }
}

TEST_F(LittleSpace, EndOfTheRecordingIsReportedFirst) {
  for (const char* command : {"run short.toml", "loop short.toml --virtual --seconds 5"}) {
    SCOPED_TRACE(command);
    std::filesystem::remove_all(folder_ / "m_after");
    std::filesystem::remove_all(folder_ / "n_after");
    const ProgramResult result = Within(Mount("m", 8) + " && " + Mount("n", 100),
                                        fmt::format("'" KERF_PROGRAM "' {} -o n/out --record m/session.kerf", command));
    EXPECT_EQ(result.code, 1);
    const std::vector<std::string> sentences = Sentences(result);
    ASSERT_EQ(sentences.size(), 2u) << result.err;
    EXPECT_THAT(sentences[0], testing::MatchesRegex(R"(kerf: the recording ended at [0-9]\.[0-9]+ s: m/session\.kerf: )"
                                                    R"(can't be written any further: No space left on device)"));
    EXPECT_THAT(sentences[1], HasSubstr("can't be written"));
    const double said_s = std::stod(sentences[0].substr(sentences[0].find(" at ") + 4));
    EXPECT_NEAR(Seconds("m_after/session.kerf"), said_s, 1e-3);
  }
}

// The recording is complete although the results of the run are not.
TEST_F(LittleSpace, RecordingOfARunIsFinishedBeforeItsResults) {
  const ProgramResult result =
      Within(Mount("m", 100), "'" KERF_PROGRAM "' run short.toml -o m/out --record session.kerf");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(Sentences(result), testing::ElementsAre(HasSubstr("can't be written")));
  const ProgramResult replayed = Kerf("replay session.kerf --verify");
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_THAT(Kerf("log session.kerf").out, HasSubstr("the path's end"));
}

}  // namespace
}  // namespace kerf
