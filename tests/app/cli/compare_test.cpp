// Tests of kerf compare as a user runs it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

const std::string kCompareScene = "title = \"Small block\"\n" + test::BlockToml({6, 2, 3}, 0.25) +
                                  test::StrokeToml({0, 0, 11.5}, {0, 0, 6}, 12, {0, 1, 0});
const std::string kSlab = "[slab]\ndirection = [0, 0, -1]\n";

class Compare : public test::ProgramTest {};

TEST_F(Compare, WritesReportFiguresTableAndJson) {
  Write("small.toml", kCompareScene + kSlab);
  const auto result = Kerf("compare small.toml -o out --laws all --repeat 1");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("slab as computed"));
  // Every warning of the report is also printed on stderr.
  const auto json = nlohmann::json::parse(test::Slurp(folder_ / "out/compare.json"));
  EXPECT_FALSE(json["warnings"].empty());
  for (const std::string warning : json["warnings"]) {
    EXPECT_THAT(result.err, HasSubstr("kerf: warning: " + warning + "\n"));
    EXPECT_THAT(test::Slurp(folder_ / "out/report.md"), HasSubstr("- " + warning + "\n"));
  }
  for (const char* file :
       {"report.md", "force_depth.png", "difference.png", "cost.png", "compare.csv", "compare.json"}) {
    EXPECT_TRUE(Exists(std::string("out/") + file)) << file;
  }
  EXPECT_THAT(test::Slurp(folder_ / "out/report.md"), HasSubstr("# Small block"));
  // The files contain no path of this machine.
  for (const char* file : {"report.md", "compare.csv", "compare.json"}) {
    EXPECT_EQ(test::Slurp(folder_ / "out" / file).find(folder_.string()), std::string::npos) << file;
  }
}

TEST_F(Compare, JsonOnStdoutEqualsTheFile) {
  Write("small.toml", kCompareScene + kSlab);
  const auto result = Kerf("compare small.toml -o out --laws hertz_constant_bite --repeat 1 --depth-step 0.2 --json");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, test::Slurp(folder_ / "out/compare.json"));
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["schema"], 1);
  EXPECT_EQ(json["depth_step_mm"], 0.2);
  ASSERT_EQ(json["cases"].size(), 4u);
  EXPECT_EQ(json["cases"][1]["id"], "voxel_hertz_constant_bite");
  EXPECT_EQ(json["cases"][0]["slice"]["rms_difference_N"], 0);
}

TEST_F(Compare, CommandOfTheReportMakesTheSameTable) {
  Write("small.toml", kCompareScene + kSlab);
  const auto first = Kerf("compare " + (folder_ / "small.toml").string() +
                          " -o out --laws hertz_constant_bite,edge_plus_chip --repeat 1 --depth-step 0.2");
  EXPECT_EQ(first.code, 0) << first.err;
  const std::string report = test::Slurp(folder_ / "out/report.md");
  const std::size_t at = report.find("```\nkerf compare small.toml ");
  ASSERT_NE(at, std::string::npos);
  const std::size_t from = at + std::string("```\nkerf ").size();
  const auto again = Kerf(report.substr(from, report.find('\n', from) - from) + " -o again");
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(test::Slurp(folder_ / "again/compare.csv"), test::Slurp(folder_ / "out/compare.csv"));
  const auto json = [&](const char* folder) {
    return nlohmann::json::parse(test::Slurp(folder_ / folder / "compare.json"));
  };
  EXPECT_EQ(json("again")["command"], json("out")["command"]);
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(json("again")["cases"][k]["force_hash"], json("out")["cases"][k]["force_hash"]);
  }
}

TEST_F(Compare, BadUsageIsRefusedInOneSentence) {
  Write("no_slab.toml", kCompareScene);
  auto result = Kerf("compare no_slab.toml -o out");
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.err, HasSubstr("kerf: no_slab: to compare with slab mode the scene needs the cut direction"));
  Write("small.toml", kCompareScene + kSlab);
  result = Kerf("compare small.toml -o out --laws hertz");
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--laws: there is no force law \"hertz\"; available: two_component, hertz_chip, "
                                    "hertz_constant_bite, edge_plus_chip, tabulated; see 'kerf compare --help'\n"));
  result = Kerf("compare small.toml -o out --depth-step 0");
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--depth-step: 0 is below 0.005; valid range 0.005 to 5 mm; "
                                    "see 'kerf compare --help'\n"));
  result = Kerf("compare small.toml -o out --repeat 0");
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--repeat: 0 is below 1; valid range 1 to 100; see 'kerf compare --help'\n"));
  EXPECT_EQ(Kerf("compare").code, 2);
  EXPECT_FALSE(Exists("out/report.md"));
}

}  // namespace
}  // namespace kerf
