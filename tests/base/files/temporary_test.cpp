#include "base/files/temporary.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <regex>
#include <set>
#include <vector>

#include "base/files/files.h"
#include "base/files/folder_lock.h"
#include "support/folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kPattern[] = R"(\.bone\.kerf-[0-9a-f]{8}-[0-9a-f]{16}\.vdb)";

class Temporaries : public ::testing::Test {
 protected:
  std::vector<std::string> Names(const std::string& folder = "") const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(own_.file(folder))) names.push_back(entry.path().filename());
    return names;
  }
  /// Returns the name of the only file in the folder.
  std::string Name() const { return Names().at(0); }
  /// Returns the id of a process that has ended and has been waited for.
  static pid_t DeadProcess() {
    const pid_t child = fork();
    if (child == 0) _exit(0);
    waitpid(child, nullptr, 0);
    return child;
  }
  test::Folder own_;
};

/// Another process that runs `work`, reports that it is done, and then lives until it is killed.
class OtherProcess {
 public:
  explicit OtherProcess(const std::function<void()>& work) {
    int ends[2];
    EXPECT_EQ(pipe(ends), 0);
    child_ = fork();
    if (child_ == 0) {
      work();
      EXPECT_EQ(write(ends[1], "x", 1), 1);
      for (;;) pause();
    }
    close(ends[1]);
    char done = 0;
    EXPECT_EQ(read(ends[0], &done, 1), 1);
    close(ends[0]);
  }
  ~OtherProcess() { Kill(); }
  void Kill() {
    if (child_ <= 0) return;
    kill(child_, SIGKILL);
    waitpid(child_, nullptr, 0);
    child_ = 0;
  }

 private:
  pid_t child_ = 0;
};

TEST_F(Temporaries, HaveRandomNamesBesideTheirTarget) {
  std::set<std::string> names;
  for (int i = 0; i < 100; ++i) {
    const Temporary temporary(own_.file("bone.vdb"));
    EXPECT_TRUE(std::regex_match(Name(), std::regex(kPattern))) << Name();
    names.insert(Name());
  }
  EXPECT_EQ(names.size(), 100u);
  EXPECT_THAT(Names(), IsEmpty());
}

TEST_F(Temporaries, NamesForLongTargetsAreShortened) {
  const std::string longest(251, 'n');
  WriteTextFile(own_.file(longest + ".csv"), "x");
  EXPECT_EQ(Name(), longest + ".csv");
  EXPECT_THAT(test::MessageOf([&] { WriteTextFile(own_.file("n" + longest + ".csv"), "x"); }),
              HasSubstr("can't be written: File name too long"));
}

// The writer gets a path that leads to the open file itself; a link that another program puts in the place of the
// file's name receives no data.
TEST_F(Temporaries, LinkUnderTheirNameRedirectsNothing) {
  test::WriteBytes(own_.file("victim"), "untouched");
  fs::create_directory(own_.file("out"));
  const std::string message = test::MessageOf([&] {
    WriteAtomically(own_.file("out/a.csv"), [&](const std::string& temporary) {
      const std::string name = own_.file("out/" + Names("out").at(0));
      fs::remove(name);
      fs::create_symlink("../victim", name);
      test::WriteBytes(temporary, "secret");
    });
  });
  EXPECT_THAT(message, HasSubstr("another program has replaced its temporary file"));
  EXPECT_EQ(test::ReadBytes(own_.file("victim")), "untouched");
  EXPECT_THAT(Names("out"), IsEmpty());
}

// These are the names that an earlier version would have opened; they contained the process id.
TEST_F(Temporaries, PlantedLinksOfPredictableNamesAreNotFollowed) {
  test::WriteBytes(own_.file("victim"), "untouched");
  fs::create_directory(own_.file("out"));
  for (int i = 0; i < 50; ++i) {
    fs::create_symlink("../victim", own_.file(fmt::format("out/.forces.{}-{}.csv", getpid(), i)));
  }
  WriteTextFile(own_.file("out/forces.csv"), "rows");
  EXPECT_EQ(test::ReadBytes(own_.file("victim")), "untouched");
  EXPECT_EQ(test::ReadBytes(own_.file("out/forces.csv")), "rows");
  EXPECT_EQ(Names("out").size(), 51u);
}

TEST_F(Temporaries, KeepTheEarlierFilesPermissions) {
  WriteTextFile(own_.file("a.csv"), "old");
  fs::permissions(own_.file("a.csv"), fs::perms::owner_read | fs::perms::owner_write);
  GrowingFile file(own_.file("a.csv"));
  for (const std::string& name : Names()) {
    EXPECT_EQ(fs::status(own_.file(name)).permissions(), fs::perms::owner_read | fs::perms::owner_write) << name;
  }
  file.Commit();
  EXPECT_EQ(fs::status(own_.file("a.csv")).permissions(), fs::perms::owner_read | fs::perms::owner_write);
}

TEST_F(Temporaries, LeftoversOfAKilledProgramAreRemovedByTheNextWrite) {
  OtherProcess other([&] {
    auto* left = new Temporary(own_.file("forces.csv"));
    test::WriteBytes(left->path_to_write(), "half");
  });
  EXPECT_EQ(Names().size(), 1u);
  fs::create_directory_symlink(".", own_.file("same"));  // a second path, because each folder is swept only once
  WriteTextFile(own_.file("living.csv"), "x");
  EXPECT_EQ(Names().size(), 3u) << "the owner is still alive";
  other.Kill();
  WriteTextFile(own_.file("same/dead.csv"), "x");
  EXPECT_THAT(Names(), testing::UnorderedElementsAre("living.csv", "dead.csv", "same"));
}

TEST_F(Temporaries, SweepKeepsForeignFiles) {
  const std::string name = ".a\nb.kerf-0123abcd-0123456789abcdef.csv";  // a name may contain a line break
  // These names have a different form: too short, not hexadecimal, or not hidden.
  const std::vector<std::string> foreign = {".a.kerf-0123abcd-0123456789abcde.csv",
                                            ".a.kerf-0123abcd-0123456789abcdeg.csv",
                                            "a.kerf-0123abcd-0123456789abcdef.csv", ".a.csv"};
  for (const std::string& file : foreign) test::WriteBytes(own_.file(file), "x");
  // These names have the right form, but are those of a folder, a link, and a file with a second hard link.
  fs::create_directory(own_.file(".f.kerf-0123abcd-0123456789abcdef.csv"));
  fs::create_symlink("a.csv", own_.file(".l.kerf-0123abcd-0123456789abcdef.csv"));
  test::WriteBytes(own_.file("two"), "x");
  fs::create_hard_link(own_.file("two"), own_.file(".h.kerf-0123abcd-0123456789abcdef.csv"));
  const std::size_t before = Names().size();
  test::WriteBytes(own_.file(name), "left");
  SweepLeftovers(own_.file("any.csv"));
  EXPECT_EQ(Names().size(), before);
  EXPECT_FALSE(fs::exists(own_.file(name)));
}

TEST_F(Temporaries, OldStyleLeftoversAreRemovedIfTheirProcessIsDead) {
  const pid_t dead = DeadProcess();
  const std::string left = fmt::format(".forces.{}-0.csv", dead);
  const std::string open_elsewhere = fmt::format(".forces.{}-1.csv", dead);
  const std::string living = fmt::format(".forces.{}-0.csv", getpid());
  const std::string other_target = fmt::format(".bone.{}-0.vdb", dead);
  const std::string diary = fmt::format(".diary.{}-11.csv", dead);  // nothing sweeps diary.csv here
  for (const std::string& name : {left, open_elsewhere, living, other_target, diary}) {
    test::WriteBytes(own_.file(name), "half");
  }
  // A process in another container has no id here, but it keeps the file open.
  const int held = open(own_.file(open_elsewhere).c_str(), O_WRONLY | O_CLOEXEC);
  SweepLeftovers(own_.file("forces.csv"));
  EXPECT_THAT(Names(), testing::UnorderedElementsAre(open_elsewhere, living, other_target, diary));
  SweepLeftovers(own_.file("bone.vdb"));
  EXPECT_THAT(Names(), testing::UnorderedElementsAre(open_elsewhere, living, diary));
  close(held);
}

TEST_F(Temporaries, TemporaryFolderIsRemovedWithItsContent) {
  std::string path;
  {
    const TemporaryFolder folder("kerf_test");
    path = folder.path();
    EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_all);
    test::WriteBytes(path + "/a", "x");
    EXPECT_NE(TemporaryFolder("kerf_test").path(), path);
  }
  EXPECT_FALSE(fs::exists(path));
}

TEST_F(Temporaries, FolderLockRemovesTheEmptyFoldersThatItHasMade) {
  namespace fs = std::filesystem;
  {
    const FolderLock lock(own_.file("a/b/"));
  }
  EXPECT_FALSE(fs::exists(own_.file("a")));
  fs::create_directory(own_.file("there"));
  { const FolderLock lock(own_.file("there/c")); }
  EXPECT_FALSE(fs::exists(own_.file("there/c")));
  { const FolderLock lock(own_.file("there")); }
  EXPECT_TRUE(fs::exists(own_.file("there"))) << "it was there before";
  {
    const FolderLock lock(own_.file("there/d/e"));
    test::WriteBytes(own_.file("there/d/result"), "x");
  }
  EXPECT_FALSE(fs::exists(own_.file("there/d/e")));
  EXPECT_TRUE(fs::exists(own_.file("there/d/result")));
}

TEST_F(Temporaries, SignalHandlerRemovesTheEmptyFoldersThatAFolderLockHasMade) {
  namespace fs = std::filesystem;
  fs::create_directory(own_.file("there"));
  const FolderLock empty(own_.file("there/a/b/"));
  const FolderLock used(own_.file("there/c/d"));
  const FolderLock made_before(own_.file("there"));
  test::WriteBytes(own_.file("there/c/result"), "x");
  RemoveLiveTemporaries();
  EXPECT_FALSE(fs::exists(own_.file("there/a")));
  EXPECT_FALSE(fs::exists(own_.file("there/c/d")));
  EXPECT_TRUE(fs::exists(own_.file("there/c/result")));
  fs::remove_all(own_.file("there/c"));
  RemoveLiveTemporaries();
  EXPECT_TRUE(fs::exists(own_.file("there"))) << "it was there before";
}

TEST_F(Temporaries, SignalHandlerRemovesTemporaryFoldersWithTheirContentAndFollowsNoLink) {
  namespace fs = std::filesystem;
  fs::create_directory(own_.file("kept"));
  test::WriteBytes(own_.file("kept/file"), "x");
  const TemporaryFolder folder("kerf_test");
  fs::create_directories(folder.path() + "/a/b/c");
  for (int i = 0; i < 500; ++i) test::WriteBytes(folder.path() + "/a/b/a rather long name " + std::to_string(i), "x");
  fs::create_directory_symlink(own_.file("kept"), folder.path() + "/a/link");
  RemoveLiveTemporaries();
  EXPECT_FALSE(fs::exists(folder.path()));
  EXPECT_TRUE(fs::exists(own_.file("kept/file")));
}

TEST_F(Temporaries, FolderLockIsHeldUntilTheProgramEndsOrIsKilled) {
  const std::string folder = own_.file("a/b");
  const std::string refusal = folder + ": another kerf is writing results into this folder";
  const auto lock = [&] { const FolderLock one(folder); };
  {
    const FolderLock held(folder);
    EXPECT_THAT(test::MessageOf(lock), HasSubstr(refusal));
    const FolderLock beside(own_.file("a"));
    // Readers and writers that do not use the lock are not blocked, and the lock leaves no file in the folder.
    test::WriteBytes(folder + "/x", "x");
    EXPECT_EQ(ReadTextFile(folder + "/x"), "x");
    EXPECT_EQ(Names("a/b"), std::vector<std::string>{"x"});
  }
  EXPECT_EQ(test::MessageOf(lock), "");
  OtherProcess other([&] { new FolderLock(folder); });
  EXPECT_THAT(test::MessageOf(lock), HasSubstr(refusal));
  other.Kill();
  EXPECT_EQ(test::MessageOf(lock), "");
  fs::create_directory_symlink("a", own_.file("link"));
  const FolderLock held(own_.file("link/b"));
  EXPECT_THAT(test::MessageOf(lock), HasSubstr(refusal)) << "under another name";
}

}  // namespace
}  // namespace kerf
