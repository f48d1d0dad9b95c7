// Tests that only one program at a time uses a folder of results, and that the leftovers of a killed one are removed.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>

#include "base/files/folder_lock.h"
#include "support/block_scene.h"
#include "support/program.h"
#include "support/running.h"
#include "test_paths.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using test::MakeBlockScene;
using test::ProgramResult;
using testing::HasSubstr;

constexpr char kMore[] = "[output]\npictures = false\n[slab]\ndirection = [0, 0, -1]\n";

class Litter : public test::ProgramTest {
 protected:
  Litter() : ProgramTest({{"s.toml", MakeBlockScene({.from_mm = 6.5, .to_mm = 5.5, .feed_mm_per_s = 6}, kMore)}}) {}
  std::set<std::string> Hidden(const std::string& folder) const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_ / folder)) {
      const std::string name = entry.path().filename();
      if (name.starts_with('.')) names.insert(name);
    }
    return names;
  }
};

class HeldFolder : public Litter, public testing::WithParamInterface<std::string> {};

TEST_P(HeldFolder, IsRefusedImmediatelyAndUnchanged) {
  ASSERT_EQ(Kerf("run s.toml -o first --record r.kerf").code, 0);
  ASSERT_EQ(Kerf("loop s.toml --virtual --seconds 0.1 --record l.kerf").code, 0);
  fs::create_directory(folder_ / "out");
  Write("out/forces.csv", "the other's\n");
  std::optional<FolderLock> other(folder_ / "out");
  const ProgramResult refused = Kerf(GetParam());
  EXPECT_EQ(refused.code, 1);
  EXPECT_EQ(refused.out, "");
  EXPECT_EQ(refused.err,
            "kerf: out: another kerf is writing results into this folder; wait until it has finished, or choose "
            "another folder\n");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), {}), 1);
  EXPECT_EQ(test::Slurp(folder_ / "out/forces.csv"), "the other's\n");
  EXPECT_FALSE(Exists("new.kerf"));
}

INSTANTIATE_TEST_SUITE_P(Commands, HeldFolder,
                         testing::Values("run s.toml -o out --record new.kerf",
                                         "loop s.toml --virtual --seconds 0.1 -o out --record new.kerf",
                                         "replay r.kerf -o out", "replay l.kerf -o out",
                                         "compare s.toml -o out --repeat 1", "stability s.toml -o out",
                                         "assess s.toml --after first/bone.vdb -o out --no-pictures",
                                         "slab first/bone.vdb --plane 0,0,0,1,0,0 --thickness 0.5 --no-picture -o out",
                                         "bench hour s.toml --minutes 1 -o out", "bench growth -o out",
                                         "study " KERF_SOURCE_DIR "/scenes/study_quick.toml -o out"));

TEST_F(Litter, RunThatFailsLeavesNoEmptyFolder) {
  Write("damaged.toml", "title = \n");
  Write("damaged.vdb", "this is no volume");
  Write("no_bone.toml", MakeBlockScene({.from_mm = 6.5, .to_mm = 5.5, .feed_mm_per_s = 6}, kMore));
  std::string text = test::Slurp(folder_ / "no_bone.toml");
  text = "[bone]\nfile = \"damaged.vdb\"\n" + text.substr(text.find("[tool]"));
  Write("no_bone.toml", text);
  for (const char* command :
       {"run damaged.toml", "run no_bone.toml", "loop missing.toml --virtual", "loop no_bone.toml --virtual",
        "compare no_bone.toml --repeat 1", "run no_bone.toml --uncertain --samples 2", "stability damaged.toml",
        "assess no_bone.toml --after damaged.vdb", "slab damaged.vdb --plane 0,0,0,1,0,0 --thickness 0.5",
        "replay missing.kerf", "rehearse missing.vdb", "practise --exercise none", "study damaged.toml",
        "bench hour no_bone.toml --minutes 1", "bench growth --core 4095"}) {
    const ProgramResult result = Kerf(std::string(command) + " -o new/out");
    EXPECT_NE(result.code, 0) << command;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << command << ": " << result.err;
    EXPECT_FALSE(Exists("new")) << command << ": " << result.err;
  }
}

TEST_F(Litter, RunThatIsInterruptedLeavesNoEmptyFolder) {
  // A million ticks, so that it is still cutting when the signal comes.
  Write("long.toml", MakeBlockScene({.from_mm = 6.5, .to_mm = 5.5, .feed_mm_per_s = 0.001}, kMore));
  for (const char* command : {"run long.toml", "compare long.toml --repeat 1"}) {
    test::Running run(folder_, test::At::kNoTerminal, std::string("'" KERF_PROGRAM "' ") + command + " -o new/out");
    ASSERT_TRUE(run.Until([&] { return Exists("new/out"); })) << run.err();
    run.Signal(SIGINT);
    EXPECT_EQ(run.WaitForEnd(), 128 + SIGINT) << command;
    EXPECT_FALSE(Exists("new")) << command;
  }
}

TEST_F(Litter, LockDoesNotExcludeReaders) {
  ASSERT_EQ(Kerf("run s.toml -o out").code, 0);
  const FolderLock other(folder_ / "out");
  EXPECT_EQ(Kerf("info out/bone.vdb").code, 0);
  EXPECT_EQ(Kerf("export out/bone.vdb -o x.stl").code, 0);
  EXPECT_EQ(Kerf("run s.toml -o elsewhere").code, 0);
  EXPECT_EQ(Kerf("run out/scene.toml -o elsewhere").code, 0);
}

// A second program runs, the first is killed, and a third program runs afterwards.
TEST_F(Litter, OfAKilledLoopIsRemovedByTheNextRunWithItsLock) {
  {
    test::Running loop(folder_, test::At::kNoTerminal, "'" KERF_PROGRAM "' loop s.toml --seconds 60 -o out");
    ASSERT_TRUE(loop.Until([&] { return Exists("out") && !Hidden("out").empty(); })) << loop.err();
    EXPECT_THAT(Kerf("loop s.toml --virtual --seconds 0.1 -o out").err, HasSubstr("another kerf is writing results"));
    EXPECT_EQ(Hidden("out").size(), 1u) << "the living program's file stays";
    loop.Signal(SIGKILL);
    EXPECT_EQ(loop.WaitForEnd(), 128 + SIGKILL);
  }
  ASSERT_EQ(Hidden("out").size(), 1u);
  EXPECT_THAT(*Hidden("out").begin(), testing::MatchesRegex(R"(\.forces\.kerf-[0-9a-f]+-[0-9a-f]+\.csv)"));
  const ProgramResult next = Kerf("loop s.toml --virtual --seconds 0.1 -o out");
  EXPECT_EQ(next.code, 0) << next.err;
  EXPECT_THAT(Hidden("out"), testing::IsEmpty());
}

TEST_F(Litter, OfEarlierVersionsIsRemovedAndForeignFilesAreKept) {
  fs::create_directory(folder_ / "out");
  // The names contain process ids above the maximum.
  for (const char* name :
       {".forces.4194305-0.csv", ".bone.4194305-3.vdb", ".forces.1-0.csv", ".diary.4194305-11.csv"}) {
    Write(std::string("out/") + name, "x");
  }
  ASSERT_EQ(Kerf("run s.toml -o out").code, 0);
  EXPECT_EQ(Hidden("out"), (std::set<std::string>{".forces.1-0.csv", ".diary.4194305-11.csv"}));
}

TEST_F(Litter, ALinkInPlaceOfARecordingIsRefused) {
  Write("victim", "untouched");
  for (const char* target : {"victim", "missing"}) {
    fs::remove(folder_ / "session.kerf");
    fs::create_symlink(target, folder_ / "session.kerf");
    const ProgramResult result = Kerf("loop s.toml --virtual --seconds 0.1 --record session.kerf");
    EXPECT_EQ(result.code, 1);
    EXPECT_THAT(result.err, HasSubstr("session.kerf: already exists; a recording never replaces a file"));
  }
  EXPECT_EQ(test::Slurp(folder_ / "victim"), "untouched");
  EXPECT_FALSE(Exists("missing"));
}

}  // namespace
}  // namespace kerf
