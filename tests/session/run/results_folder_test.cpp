#include "session/run/results_folder.h"

#include <gmock/gmock.h>

#include <filesystem>

#include "support/folder.h"

namespace kerf {
namespace {

using ::testing::UnorderedElementsAre;

// Files of all types that runs and studies write may be removed. No other file is removed, whatever a list contains.
TEST(ResultsFolder, OnlyTheResultsOfAnEarlierRunAreListed) {
  const test::Folder folder;
  test::WriteBytes(folder.file("study.json"), R"({"kerf": "1", "files": ["a.svg", "a.png", "report.md", "cases.csv",
    "mine.toml", "../above.svg", 7]})");
  const std::vector<std::string> earlier = ReadEarlierResults(folder.path(), "study.json");
  EXPECT_THAT(earlier, UnorderedElementsAre("a.svg", "a.png", "report.md", "cases.csv"));
}

TEST(ResultsFolder, PiecesThatExistOrHaveTheNameOfAnInputAreListed) {
  const test::Folder folder;
  test::WriteBytes(folder.file("piece_2.stl"), "x");
  test::WriteBytes(folder.file("other.stl"), "x");
  const std::string a = folder.path() + "/piece_2.stl", b = folder.path() + "/piece_7.stl";
  EXPECT_THAT(ListPieceFiles(folder.path(), {"there/piece_7.stl", "bone.vdb", ""}), UnorderedElementsAre(a, b));
  EXPECT_THAT(ListPieceFiles(folder.path() + "/none", {}), testing::IsEmpty());
}

TEST(ResultsFolder, ForeignOrDamagedListYieldsNoFiles) {
  const test::Folder folder;
  EXPECT_TRUE(ReadEarlierResults(folder.path(), "study.json").empty());
  test::WriteBytes(folder.file("study.json"), R"({"files": ["a.svg"]})");
  EXPECT_TRUE(ReadEarlierResults(folder.path(), "study.json").empty());
  test::WriteBytes(folder.file("study.json"), "{");
  EXPECT_TRUE(ReadEarlierResults(folder.path(), "study.json").empty());
}

}  // namespace
}  // namespace kerf
