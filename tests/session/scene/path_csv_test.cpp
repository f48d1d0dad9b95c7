// Tests of path files: valid contents, and the reported position of a fault.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <random>

#include "base/files/files.h"
#include "kerf/error.h"
#include "scene_text.h"
#include "session/scene/path_csv.h"
#include "support/folder.h"

namespace kerf {
namespace {

const std::string kHeader = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n";

std::string PathMessageFor(const std::string& text) {
  return test::MessageOf([&] { ParsePathCsv(text, "p.csv"); });
}

TEST(PathCsv, RowsComeBackAsWritten) {
  const auto rows =
      ParsePathCsv("# a comment\r\n" + kHeader + "0.5, 1,2.5,-3e1 ,1,0,0,0\r\n\n0.75,0,0,0,0,0,0,-1", "p.csv");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].time_s, 0.5);
  EXPECT_EQ(rows[0].X_WT.p_AB, Vec3(1, 2.5, -30));
  EXPECT_EQ(rows[1].time_s, 0.75);
  EXPECT_EQ(rows[1].X_WT.R_AB, Quat(0, 0, 0, -1));
}

TEST(PathCsv, RoundedQuaternionsAreNormalised) {
  const auto rows = ParsePathCsv(kHeader + "0,0,0,0,0.7071,0,0.7071,0\n1,0,0,0,1,0,0,0\n", "p.csv");
  EXPECT_NEAR(glm::length(rows[0].X_WT.R_AB), 1, 1e-15);
}

TEST(PathCsv, FaultsHaveLineAndColumn) {
  EXPECT_EQ(PathMessageFor(kHeader + "0,1,2,nan,1,0,0,0\n1,0,0,0,1,0,0,0\n"),
            "p.csv:2:7: z_mm = \"nan\" is not a finite number");
  EXPECT_EQ(PathMessageFor(kHeader + "0,1,2,3,1,0,0,0\n1, inf,0,0,1,0,0,0\n"),
            "p.csv:3:4: x_mm = \"inf\" is not a finite number");
  EXPECT_EQ(PathMessageFor(kHeader + "0,1,2,3,1,0,0,0\n1,,0,0,1,0,0,x\n"),
            "p.csv:3:3: x_mm = \"\" is not a finite number\np.csv:3:14: qz = \"x\" is not a finite number");
  EXPECT_EQ(PathMessageFor(kHeader + "0,1,2,3,1,0,0,0\n0,0,0,0,1,0,0,0\n"),
            "p.csv:3:1: time_s = 0 is not at least 1e-06 s after the previous row, 0");
  EXPECT_EQ(
      PathMessageFor(kHeader + "0,1,2,3,1,0,0\n1,0,0,0,1,0,0,0,9\n"),
      "p.csv:2:1: 7 columns; a row has 8: time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n"
      "p.csv:3:1: more than 8 columns; a row has 8: time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz; if the numbers have decimal "
      "commas, save the table again with decimal points");
  EXPECT_EQ(PathMessageFor(kHeader + "0,1,2,3,0.9,0,0,0\n1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,0\n"),
            "p.csv:2:9: the quaternion has length 0.9; it must be 1");
  EXPECT_EQ(PathMessageFor(kHeader + "0,1000001,2,3,1,0,0,0\n1,0,0,0,1,0,0,0\n2,0,0,0,1,0,0,0\n"),
            "p.csv:2:3: x_mm = 1000001 is above 1000000; valid range -1000000 to 1000000 mm");
  EXPECT_EQ(PathMessageFor("time,x,y,z,qw,qx,qy,qz\n0,0,0,0,1,0,0,0\n"),
            "p.csv:1:1: the header must be time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz");
  EXPECT_EQ(PathMessageFor(""), "p.csv:1:1: no header; it must be time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz");
  EXPECT_EQ(PathMessageFor(kHeader + "0,0,0,0,1,0,0,0\n"), "p.csv:2:1: 1 rows; a path has at least 2");
  EXPECT_EQ(PathMessageFor(kHeader + "0,0,0,0,1,0,0,0\n36001,0,0,0,1,0,0,0\n"),
            "p.csv:3:1: the path takes 36001 s; at most 36000 s");
}

TEST(PathCsv, SemicolonsAndDecimalCommasAreNamed) {
  std::string german = kHeader;
  std::replace(german.begin(), german.end(), ',', ';');
  EXPECT_THAT(PathMessageFor(german + "0;0,5;0;0;1;0;0;0\n"),
              testing::HasSubstr("; the columns are separated by semicolons: save the table again with commas"));
  EXPECT_THAT(PathMessageFor(kHeader + "0,1,5,2,3,1,0,0,0\n"),
              testing::HasSubstr("; if the numbers have decimal commas, save the table again with decimal points"));
}

TEST(PathCsv, TooManyLinesAreRefusedBeforeParsing) {
  EXPECT_EQ(PathMessageFor(std::string(2001001, '\n')), "p.csv: 2001002 lines; a path has at most 2000000 rows");
}

TEST(PathCsv, DamagedFilesNeverCrash) {
  std::string good = kHeader;
  for (int i = 0; i < 20; ++i) good += fmt::format("{},{},2,3,1,0,0,0\n", 0.25 * i, 0.125 * i);
  ASSERT_EQ(PathMessageFor(good), "");
  std::mt19937 random(3);
  int refused = 0;
  for (int i = 0; i < 5000; ++i) {
    std::string text = good;
    for (int k = 0; k < 1 + i % 3; ++k) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0) {
        text[at] = static_cast<char>(random() % 256);
      } else {
        text.erase(at, random() % 30);
      }
    }
    const std::string message = PathMessageFor(text);
    if (message.empty()) continue;
    ++refused;
    EXPECT_EQ(message.rfind("p.csv:", 0), 0U) << message;
  }
  EXPECT_GT(refused, 1000);
}

TEST(PathCsv, IsFoundRelativeToTheScene) {
  const test::Folder own;
  const std::filesystem::path folder = own.path();
  std::filesystem::create_directories(folder / "sub");
  WriteTextFile((folder / "sub" / "p.csv").string(), kHeader + "1,0,0,0,1,0,0,0\n3,4,0,0,1,0,0,0\n");
  const std::string text = "[bone]\nmodel = \"block\"\n[path]\nfile = \"sub/p.csv\"\n";
  const std::string file = (folder / "s.toml").string();
  WriteTextFile(file, text);
  const Scene scene = ReadScene(file);
  EXPECT_EQ(scene.name, "s");
  EXPECT_EQ(scene.path.file, (folder / "sub" / "p.csv").string());
  EXPECT_EQ(scene.path.poses.size(), 2U);
  // The resolved scene still names the same file when it is read from another folder.
  EXPECT_EQ(ParseScene(ResolvedToml(scene), "/elsewhere/s.toml").path.poses.size(), 2U);
  const std::string missing = test::MessageFor("[bone]\nmodel = \"block\"\n[path]\nfile = \"none.csv\"\n", file);
  EXPECT_EQ(missing.rfind(file + ":4:1: ", 0), 0U) << missing;
  EXPECT_NE(missing.find("none.csv"), std::string::npos) << missing;
}

}  // namespace
}  // namespace kerf
