#include "base/files/files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "kerf/error.h"
#include "support/folder.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class Files : public ::testing::Test {
 protected:
  std::string Path(const std::string& name) const { return folder_ + "/" + name; }
  std::size_t CountFiles(const std::string& in = "") const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(Path(in)), fs::directory_iterator()));
  }
  test::Folder own_;
  std::string folder_ = own_.path();
};

TEST_F(Files, ReadGivesBackWhatWasWritten) {
  std::string all_bytes;
  for (int i = 0; i < 300000; ++i) all_bytes.push_back(static_cast<char>(i * 7));
  WriteTextFile(Path("a.bin"), all_bytes);
  EXPECT_EQ(ReadTextFile(Path("a.bin")), all_bytes);
  WriteTextFile(Path("a.bin"), "");
  EXPECT_EQ(ReadTextFile(Path("a.bin")), "");
  EXPECT_EQ(CountFiles(), 1u);
}

TEST_F(Files, FailedWriteKeepsTheOldFileAndLeavesNoTemporary) {
  WriteTextFile(Path("a.txt"), "old");
  EXPECT_EQ(test::MessageOf([&] {
              WriteAtomically(Path("a.txt"), [](const std::string& temporary) {
                std::ofstream(temporary) << "half";
                throw Error("the writer failed");
              });
            }),
            "the writer failed");
  EXPECT_EQ(ReadTextFile(Path("a.txt")), "old");
  EXPECT_EQ(CountFiles(), 1u);
}

TEST_F(Files, MessagesNameTheFileAndTheReason) {
  EXPECT_THAT(test::MessageOf([&] { ReadTextFile(Path("none")); }), HasSubstr("none: there is no such file"));
  EXPECT_THAT(test::MessageOf([&] { ReadTextFile(folder_); }), HasSubstr("is a folder, not a file"));
  EXPECT_THAT(test::MessageOf([&] { WriteTextFile(Path("x/y.txt"), ""); }),
              HasSubstr("there is no folder " + Path("x")));
  EXPECT_THAT(test::MessageOf([&] { WriteTextFile(folder_, ""); }), HasSubstr("it is a folder"));
  WriteTextFile(Path("big"), std::string(2 << 20, 'x'));
  EXPECT_THAT(test::MessageOf([&] { ReadTextFile(Path("big"), 1 << 20); }), HasSubstr("is larger than 1 MiB"));
  EXPECT_THAT(test::MessageOf([&] { MakeFolder(Path("big")); }), HasSubstr("big: the folder can't be created"));
}

TEST_F(Files, MakeFolderMakesParentsAndMayBeRepeated) {
  MakeFolder(Path("a/b/c"));
  MakeFolder(Path("a/b/c"));
  EXPECT_TRUE(fs::is_directory(Path("a/b/c")));
}

TEST_F(Files, InputsAreRecognisedByAnyNameAndNotOverwritten) {
  WriteTextFile(Path("in.csv"), "x");
  MakeFolder(Path("out"));
  fs::create_symlink("../in.csv", Path("out/table.csv"));
  fs::create_symlink("out", Path("same"));
  const std::string sentence = Path("in.csv") + ": is an input and would be overwritten by ";
  EXPECT_EQ(test::MessageOf([&] {
              CheckInputsNotOverwritten({"", Path("in.csv")}, {Path("out/a"), Path("out/table.csv")});
            }),
            sentence + Path("out/table.csv") + "; choose another output");
  EXPECT_EQ(test::MessageOf([&] { CheckInputsNotOverwritten({Path("in.csv")}, {Path("out/../in.csv")}); }),
            sentence + Path("out/../in.csv") + "; choose another output");
  EXPECT_EQ(test::MessageOf([&] { CheckInputsNotOverwritten({Path("in.csv")}, {Path("out/new.csv"), ""}); }), "");
  // Neither file exists yet.
  EXPECT_TRUE(IsSameFile(Path("same/new.png"), Path("out/./new.png")));
  EXPECT_FALSE(IsSameFile(Path("out/new.png"), Path("new.png")));
}

TEST_F(Files, RemoveTemporariesRemovesOnlyFilesBeingWritten) {
  WriteTextFile(Path("a.txt"), "old");
  WriteTextFile(Path("b.txt"), "done");
  EXPECT_THROW(WriteAtomically(Path("a.txt"),
                               [&](const std::string& temporary) {
                                 std::ofstream(temporary) << "half";
                                 EXPECT_EQ(CountFiles(), 3u);
                                 RemoveTemporaries();
                                 EXPECT_EQ(CountFiles(), 2u);
                               }),
               Error);
  EXPECT_EQ(ReadTextFile(Path("a.txt")), "old");
  EXPECT_EQ(ReadTextFile(Path("b.txt")), "done");
  RemoveTemporaries();
  EXPECT_EQ(CountFiles(), 2u);
}

TEST_F(Files, FilesOfABatchReplaceEarlierOnesOnlyTogether) {
  MakeFolder(Path("out"));
  for (const char* name : {"a.txt", "b.txt", "stale.txt", "list"}) WriteTextFile(Path("out/") + name, "old");
  {
    FileBatch batch(Path("./out/"), "list");
    WriteTextFile(Path("out//list"), "new");
    WriteTextFile(Path("out//a.txt"), "new");
    WriteTextFile(Path("out/b.txt"), "new");
    WriteTextFile(Path("out/c.txt"), "new");
    WriteTextFile(Path("elsewhere.txt"), "does not wait");
    for (const char* name : {"a.txt", "b.txt", "list"}) EXPECT_EQ(ReadTextFile(Path("out/") + name), "old");
    EXPECT_EQ(ReadTextFile(batch.Find(Path("out/b.txt"))), "new");
    EXPECT_FALSE(fs::exists(Path("out/c.txt")));
    EXPECT_EQ(ReadTextFile(Path("elsewhere.txt")), "does not wait");
    batch.Commit({"b.txt", "stale.txt"});
    for (const char* name : {"a.txt", "b.txt", "c.txt", "list"}) EXPECT_EQ(ReadTextFile(Path("out/") + name), "new");
    EXPECT_EQ(batch.Find(Path("out/b.txt")), Path("out/b.txt"));
  }
  EXPECT_EQ(CountFiles("out"), 4u);
  WriteTextFile(Path("out/a.txt"), "without a batch");
  EXPECT_EQ(ReadTextFile(Path("out/a.txt")), "without a batch");
}

// Work that fails leaves either an earlier folder as it was or, if it would replace nothing, what it completed.
TEST_F(Files, BatchThatIsNotCommittedReplacesNothing) {
  for (const std::string earlier : {"", "a", "list"}) {
    const std::string folder = Path("out_" + earlier);
    MakeFolder(folder);
    if (!earlier.empty()) WriteTextFile(folder + "/" + earlier, "old");
    {
      const FileBatch batch(folder, "list");
      EXPECT_EQ(batch.ReplacesNothing(), earlier != "list");
      WriteTextFile(folder + "/a", "new");
      WriteTextFile(folder + "/b", "new");
      EXPECT_EQ(batch.ReplacesNothing(), earlier.empty());
    }
    EXPECT_EQ(CountFiles("out_" + earlier), earlier.empty() ? 2u : 1u);
    if (!earlier.empty()) {
      EXPECT_EQ(ReadTextFile(folder + "/" + earlier), "old");
    }
  }
}

TEST_F(Files, SignalLeavesTheFilesThatABatchWouldHaveReplaced) {
  MakeFolder(Path("out"));
  const auto name = [&](std::size_t i) { return Path("out/" + std::to_string(i)); };
  for (std::size_t i = 0; i < FileBatch::kMost; ++i) WriteTextFile(name(i), "old");
  FileBatch batch(Path("out"), "list");
  for (std::size_t i = 0; i < FileBatch::kMost; ++i) WriteTextFile(name(i), "new");
  EXPECT_EQ(CountFiles("out"), 2 * FileBatch::kMost);
  RemoveTemporaries();
  EXPECT_EQ(CountFiles("out"), FileBatch::kMost);
  for (std::size_t i = 0; i < FileBatch::kMost; ++i) EXPECT_EQ(ReadTextFile(name(i)), "old");
}

TEST_F(Files, BatchWithTooManyFilesRenamesEachInOrderAndTheListLast) {
  WriteTextFile(Path("list"), "old");
  FileBatch batch(folder_, "list");
  const auto name = [&](std::size_t i) { return Path(std::to_string(i)); };
  for (std::size_t i = 0; i < FileBatch::kMost; ++i) WriteTextFile(name(i), "new");
  EXPECT_FALSE(fs::exists(name(0)));
  for (std::size_t i = FileBatch::kMost; i < FileBatch::kMost + 3; ++i) {
    WriteTextFile(name(i), "new");
    for (std::size_t j = 0; j <= i; ++j) EXPECT_TRUE(fs::exists(name(j))) << j << " of " << i;
    EXPECT_FALSE(fs::exists(Path("list")));
  }
  WriteTextFile(Path("list"), "new");
  EXPECT_FALSE(fs::exists(Path("list")));
  batch.Commit({"0"});
  EXPECT_EQ(ReadTextFile(Path("list")), "new");
  EXPECT_TRUE(fs::exists(name(0)));
}

TEST_F(Files, FolderInWhichARenameFailedHasNoList) {
  MakeFolder(Path("out"));
  for (const char* name : {"a", "b", "list"}) WriteTextFile(Path("out/") + name, "old");
  {
    FileBatch batch(Path("out"), "list");
    for (const char* name : {"list", "a", "b"}) WriteTextFile(Path("out/") + name, "new");
    fs::remove(Path("out/b"));
    MakeFolder(Path("out/b/in_the_way"));
    const std::string message = test::MessageOf([&] { batch.Commit(); });
    EXPECT_THAT(message, testing::StartsWith(Path("out/b") + ": can't be written: "));
    EXPECT_THAT(message, testing::EndsWith("; " + Path("out") + " may have files of two runs, and has no list"));
  }
  EXPECT_EQ(ReadTextFile(Path("out/a")), "new");
  EXPECT_FALSE(fs::exists(Path("out/list")));
  EXPECT_EQ(CountFiles("out"), 2u);
}

TEST_F(Files, SignalDuringTheRenamingLeavesAllFilesOldOrAllNew) {
  constexpr std::size_t kFiles = 10;
  for (int round = 0; round < 25; ++round) {
    const auto name = [&](std::size_t i) { return Path(std::to_string(i)); };
    for (std::size_t i = 0; i < kFiles; ++i) WriteTextFile(name(i), "old");
    FileBatch batch(folder_, "9");
    for (std::size_t i = 0; i < kFiles; ++i) WriteTextFile(name(i), "new");
    // What the handler does in another thread, at various times.
    std::thread handler([&] {
      std::this_thread::sleep_for(std::chrono::microseconds(24 * round));
      RemoveTemporaries();
    });
    std::this_thread::sleep_for(std::chrono::microseconds(300));
    const std::string message = test::MessageOf([&] { batch.Commit(); });
    handler.join();
    for (std::size_t i = 0; i < kFiles; ++i) EXPECT_EQ(ReadTextFile(name(i)), message.empty() ? "new" : "old");
  }
}

TEST_F(Files, LinkIsWrittenThroughEvenIfItsTargetIsMissing) {
  MakeFolder(Path("elsewhere"));
  fs::create_symlink("elsewhere/real.txt", Path("link.txt"));
  WriteTextFile(Path("link.txt"), "first");
  EXPECT_TRUE(fs::is_symlink(Path("link.txt")));
  EXPECT_EQ(ReadTextFile(Path("elsewhere/real.txt")), "first");
  WriteTextFile(Path("link.txt"), "second");
  EXPECT_EQ(ReadTextFile(Path("elsewhere/real.txt")), "second");
}

TEST_F(Files, PathOfAFileInABatchStaysKnown) {
  FileBatch batch(folder_, "9");
  PendingFile file(Path("a"));
  file.Commit();
  EXPECT_EQ(file.path(), Path("a"));
}

TEST_F(Files, GrowingFileAppearsOnlyWhenComplete) {
  WriteTextFile(Path("a.csv"), "old");
  {
    GrowingFile file(Path("a.csv"));
    file.Append("one,");
    file.Append("");
    file.Append("two");
    EXPECT_EQ(ReadTextFile(Path("a.csv")), "old");
    EXPECT_EQ(CountFiles(), 2u);
    file.Commit();
    EXPECT_EQ(ReadTextFile(Path("a.csv")), "one,two");
    EXPECT_EQ(CountFiles(), 1u);
  }
  {
    GrowingFile file(Path("a.csv"));
    file.Append("three");
  }
  EXPECT_EQ(ReadTextFile(Path("a.csv")), "one,two");
  EXPECT_EQ(CountFiles(), 1u);
  // The folder is removed while the file is being written.
  MakeFolder(Path("gone"));
  GrowingFile file(Path("gone/a.csv"));
  file.Append("x");
  fs::remove_all(Path("gone"));
  file.Append("y");
  EXPECT_THAT(test::MessageOf([&] { file.Commit(); }), HasSubstr("gone/a.csv: can't be written: No such file"));
  EXPECT_THAT(test::MessageOf([&] { GrowingFile none(Path("none/a.csv")); }), HasSubstr("there is no folder"));
}

}  // namespace
}  // namespace kerf
