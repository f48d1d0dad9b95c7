#include "loop/record/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <random>

#include "base/files/files.h"
#include "kerf/error.h"
#include "support/folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Recordings : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }

  static RecordingHeader MakeHeader() {
    RecordingHeader header;
    header.scene_name = "a \"scene\"\n";
    header.scene_toml = "x = 1\n";
    header.bone_hash = 0xffffffffffffffff;
    header.voxel_mm = 0.1;
    header.X_WT_start = {Quat{0.6, 0.8, 0, 0}, Vec3{1, 2, 3}};
    return header;
  }
  static RecordedStep Step(int i) {
    RecordedStep step;
    step.X.p_AB = Vec3(i, 2 * i, -i);
    step.rpm = 7500;
    step.force_check = static_cast<std::uint16_t>(i);
    return step;
  }
  static void Write(const std::string& path, int steps, bool finish = true,
                    const RecordingHeader& header = MakeHeader()) {
    RecordingWriter writer(path, header, {{"/a/path.csv", "1,2,3"}});
    for (int i = 0; i < steps; ++i) writer.Add(Step(i), 1e-3 * (i + 1));
    if (finish) writer.Finish({static_cast<std::uint64_t>(steps), 1e-3 * steps, 1, 2, 3, "asked"});
  }
  static std::string ReadAll(const std::string& path) { return ReadTextFile(path); }
  static void WriteAll(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
  }
  /// Checks that all steps in the recording are those written, in order; damage() lists the missing ones.
  static void ExpectAsWritten(RecordingReader& reader) {
    std::uint64_t next = 0;
    std::uint64_t read = 0;
    std::vector<LostSteps> gaps;
    RecordedBlock block;
    for (std::size_t k = 0; reader.ReadBlock(k, block); ++k) {
      if (block.first_step != next) gaps.push_back({next, block.first_step - next, 0, 0});
      next = block.first_step;
      for (const RecordedStep& step : block.steps) {
        ASSERT_EQ(step.X.p_AB, Step(static_cast<int>(next)).X.p_AB);
        ASSERT_EQ(step.force_check, Step(static_cast<int>(next)).force_check);
        ++next;
        ++read;
      }
    }
    if (reader.end() && reader.end()->steps > next) gaps.push_back({next, reader.end()->steps - next, 0, 0});
    EXPECT_EQ(read, reader.steps());
    const RecordingDamage& damage = reader.damage();
    EXPECT_EQ(read + damage.lost_steps, damage.known_steps);
    ASSERT_EQ(damage.gaps.size(), gaps.size());
    for (std::size_t i = 0; i < gaps.size(); ++i) {
      EXPECT_EQ(damage.gaps[i].first_step, gaps[i].first_step);
      EXPECT_EQ(damage.gaps[i].count, gaps[i].count);
      EXPECT_NEAR(damage.gaps[i].from_s, 1e-3 * static_cast<double>(gaps[i].first_step), 1e-9);
      EXPECT_NEAR(damage.gaps[i].to_s, 1e-3 * static_cast<double>(gaps[i].first_step + gaps[i].count), 1e-9);
    }
    EXPECT_EQ(damage.whole_steps, gaps.empty() ? damage.known_steps : gaps.front().first_step);
  }

  test::Folder own_;
  std::string folder_ = own_.path();
};

TEST_F(Recordings, OfAnEarlierComputationAreReplayedIfTheirToolHasNoStroke) {
  RecordingHeader header;
  const auto replays = [&](int computation, const std::string& shape) {
    header.computation = computation;
    header.scene_toml = "[tool]\nshape = \"" + shape + "\"\n";
    return header.IsReplayable();
  };
  for (const char* shape : {"disc", "ball", "bur", "drill"}) {
    EXPECT_TRUE(replays(kComputation, shape) && replays(2, shape)) << shape;
    EXPECT_FALSE(replays(1, shape)) << shape;
  }
  for (const char* shape : {"reciprocating", "oscillating", "piezo"}) {
    EXPECT_TRUE(replays(kComputation, shape)) << shape;
    EXPECT_FALSE(replays(2, shape)) << shape;
  }
}

TEST_F(Recordings, OfADrillWithoutAChiselEdgeAreReadWithoutOne) {
  RecordingHeader header = MakeHeader();
  const auto read = [&](const std::string& name, const std::string& scene_toml) {
    header.scene_toml = scene_toml;
    Write(Path(name), 1, true, header);
    return RecordingReader(Path(name)).header().scene_toml;
  };
  const std::string drill = "\nshape = \"drill\"  # kind\n";
  EXPECT_EQ(read("a.kerf", "[tool]" + drill), "[tool]\nchisel_share = 0" + drill);
  EXPECT_EQ(read("b.kerf", "[tool]" + drill + "chisel_share = 0.45\n"), "[tool]" + drill + "chisel_share = 0.45\n");
  EXPECT_EQ(read("c.kerf", "[tool]\nshape = \"bur\"\n"), "[tool]\nshape = \"bur\"\n");
}

TEST_F(Recordings, RoundTripIsExact) {
  Write(Path("a.kerf"), 1100);
  RecordingReader reader(Path("a.kerf"));
  EXPECT_EQ(reader.header().scene_name, "a \"scene\"?");
  EXPECT_EQ(reader.header().bone_hash, MakeHeader().bone_hash);
  EXPECT_EQ(reader.header().X_WT_start.R_AB, MakeHeader().X_WT_start.R_AB);
  EXPECT_EQ(reader.steps(), 1100u);
  EXPECT_NEAR(reader.duration_s(), 1.1, 1e-9);
  EXPECT_EQ(reader.ReadFiles().at("/a/path.csv"), "1,2,3");
  ASSERT_TRUE(reader.end());
  EXPECT_EQ(reader.end()->bone_hash, 3u);
  EXPECT_EQ(reader.DescribeDamage(), "");
  ExpectAsWritten(reader);
}

// Text from a file must not control the terminal that displays it.
TEST_F(Recordings, ControlCharactersInTextAreReplaced) {
  RecordingHeader header = MakeHeader();
  header.machine = "a\x1b]0;title\x07 b";
  header.scene_name =
      "\xc2\x9b"
      "31m\xe2\x80\xae.txt \xc3\xa4";
  RecordingWriter(Path("a.kerf"), header, {}).Finish({});
  RecordingReader reader(Path("a.kerf"));
  EXPECT_EQ(reader.header().machine, "a?]0;title? b");
  EXPECT_EQ(reader.header().scene_name, "?31m?.txt \xc3\xa4");
}

TEST_F(Recordings, StepsCountedInItsEndMustExist) {
  {
    RecordingWriter writer(Path("a.kerf"), MakeHeader(), {});
    for (int i = 0; i < 10; ++i) writer.Add(Step(i), i);
    writer.Finish({11, 0.01, 1, 2, 3, "asked"});
  }
  EXPECT_THAT(test::MessageOf([&] { RecordingReader reader(Path("a.kerf")); }),
              HasSubstr("changed after it was written"));
}

TEST_F(Recordings, InvalidTickDurationIsRefused) {
  for (const double dt_s : {-1.0, 1e9, std::nan("")}) {
    fs::remove(Path("a.kerf"));
    {
      RecordingWriter writer(Path("a.kerf"), MakeHeader(), {});
      RecordedStep step = Step(1);
      step.dt_s = dt_s;
      writer.Add(step, 0);
      writer.Flush();
    }
    EXPECT_THAT(test::MessageOf([&] { RecordingReader reader(Path("a.kerf")); }), HasSubstr("invalid duration"));
  }
}

TEST_F(Recordings, TruncatedFileIsReadUpToTheCut) {
  Write(Path("a.kerf"), 1100);
  const std::string bytes = ReadAll(Path("a.kerf"));
  std::uint64_t most = 0;
  int opened = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    WriteAll(Path("b.kerf"), bytes.substr(0, size));
    std::optional<RecordingReader> reader;
    try {
      reader.emplace(Path("b.kerf"));
    } catch (const Error&) {
      // Opening fails only before the header is complete.
      EXPECT_EQ(opened, 0) << size;
      continue;
    }
    ++opened;
    EXPECT_NE(reader->DescribeDamage(), "");
    EXPECT_GE(reader->steps(), most);  // with more bytes there are no fewer steps
    most = reader->steps();
    if (size % 50 == 0) ExpectAsWritten(*reader);
  }
  EXPECT_EQ(most, 1100u);
}

TEST_F(Recordings, DamageIsDetectedAndTheRestIsRead) {
  Write(Path("a.kerf"), 1100);
  const std::string bytes = ReadAll(Path("a.kerf"));
  std::mt19937_64 dice(1);
  int damaged = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bad = bytes;
    const std::size_t at = dice() % bad.size();
    bad[at] = static_cast<char>(bad[at] ^ static_cast<char>(1 + dice() % 255));
    WriteAll(Path("b.kerf"), bad);
    try {
      RecordingReader reader(Path("b.kerf"));
      EXPECT_NE(reader.DescribeDamage(), "") << at;
      ExpectAsWritten(reader);
      ++damaged;
    } catch (const Error&) {
      EXPECT_LT(at, 1200u);  // the length of the header
    }
  }
  EXPECT_GT(damaged, 100);
}

TEST_F(Recordings, NeverReplacesAFile) {
  WriteAll(Path("a.kerf"), "mine");
  EXPECT_THAT(test::MessageOf([&] { Write(Path("a.kerf"), 10); }), HasSubstr("never replaces"));
  EXPECT_EQ(ReadAll(Path("a.kerf")), "mine");
  EXPECT_THAT(test::MessageOf([&] { Write(Path("none/a.kerf"), 10); }), HasSubstr("there is no folder"));
}

TEST_F(Recordings, RecordingWithoutAnEndIsReadAsFarAsItWasWritten) {
  Write(Path("a.kerf"), 1100, false);
  RecordingReader reader(Path("a.kerf"));
  EXPECT_EQ(reader.steps(), 1000u);  // blocks have 250 steps; the last hundred were not yet written
  EXPECT_THAT(reader.DescribeDamage(), HasSubstr("cut short"));
}

TEST_F(Recordings, RemovedFileIsReported) {
  RecordingWriter writer(Path("a.kerf"), MakeHeader(), {});
  fs::remove(Path("a.kerf"));
  EXPECT_THAT(test::MessageOf([&] {
                for (int i = 0; i < 1000; ++i) writer.Add(Step(i), i);
              }),
              HasSubstr("removed or replaced"));
}

// A limit on file sizes simulates a full disk: write() fails in the middle of a block.
TEST_F(Recordings, FullDiskLeavesWholeBlocks) {
  const std::string path = Path("a.kerf");
  const pid_t child = fork();
  if (child == 0) {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{20'000, 20'000};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::mt19937_64 dice(1);
    try {
      RecordingWriter writer(path, MakeHeader(), {});
      for (int i = 0; i < 100'000; ++i) {
        RecordedStep step = Step(i);
        step.bone_check = static_cast<std::uint16_t>(dice());
        writer.Add(step, 1e-3 * i);
      }
    } catch (const Error& e) {
      _exit(std::string(e.what()).find("can't be written any further") != std::string::npos ? 7 : 8);
    }
    _exit(9);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 7);
  RecordingReader reader(path);
  EXPECT_GE(reader.steps(), 250u);
  EXPECT_EQ(reader.steps() % 250, 0u);
  EXPECT_THAT(reader.DescribeDamage(), HasSubstr("cut short"));  // and no incomplete block
  ExpectAsWritten(reader);
}

TEST_F(Recordings, FilesThatAreNotRecordingsAreRefused) {
  WriteAll(Path("a.kerf"), "");
  EXPECT_THAT(test::MessageOf([&] { RecordingReader(Path("a.kerf")); }), HasSubstr("is not a kerf recording"));
  WriteAll(Path("a.kerf"), "kerf recording 1\n");
  EXPECT_THAT(test::MessageOf([&] { RecordingReader(Path("a.kerf")); }), HasSubstr("before its header"));
  EXPECT_THAT(test::MessageOf([&] { RecordingReader{folder_}; }), HasSubstr("not a regular file"));
  EXPECT_THAT(test::MessageOf([&] { RecordingReader(Path("none")); }), HasSubstr("no such file"));
}

}  // namespace
}  // namespace kerf
