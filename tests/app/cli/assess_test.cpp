// Tests of kerf assess as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using test::Slurp;
using testing::HasSubstr;

/// A bar is cut in two, 0.1 mm off the plan and inclined to it by 1.1458 degrees (a slope of 0.02).
const std::string kScene = "title = \"bar\"\n" + test::BlockToml({12, 4, 3}, 0.2) + test::SawToml(14, 0.5, 16) +
                           "[force]\nlaw = \"hertz_chip\"\n" +
                           test::StrokeToml({0.1, 0, 8.5}, {0.1, 0, 2.5}, 6, {1, 0.02, 0}) + R"([[plan.plane]]
name = "middle"
point_mm = [0, 0, -1.5]
normal = [1, 0, 0]
[[plan.stop]]
name = "through"
point_mm = [0, 0, 0]
direction = [0, 0, -1]
depth_mm = 2.5
[output]
pictures = false
)";

class AssessCommand : public test::ProgramTest {
 protected:
  AssessCommand() : ProgramTest({{"s.toml", kScene}}) {}
  void RunScene() {
    const ProgramResult run = Kerf("run s.toml -o run");
    ASSERT_EQ(run.code, 0) << run.err;
  }
  static void ExpectCut(const nlohmann::json& json) {
    const auto& plane = json["planes"][0];
    EXPECT_NEAR(plane["offset_mm"].get<double>(), 0.1, 0.1);
    EXPECT_NEAR(plane["angle_deg"].get<double>(), 1.1458, 0.1);
    EXPECT_TRUE(plane["within_margin"].get<bool>());
    EXPECT_NEAR(plane["cut"]["width_mm"].get<double>(), 0.5, 0.02);
    EXPECT_NEAR(json["stops"][0]["reached_mm"].get<double>(), 3, 0.05);
    EXPECT_NEAR(json["removed_mm3"].get<double>(), 0.5 * 4 * 3, 0.3);
  }
};

TEST_F(AssessCommand, ComparesABoneWithTheScenesPlan) {
  if (!KERF_WITH_PICTURES) GTEST_SKIP() << "this build draws no pictures";
  RunScene();
  const ProgramResult result = Kerf("assess s.toml --after run/bone.vdb -o out");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("within 1 mm"));
  EXPECT_THAT(result.out, HasSubstr("pieces            2"));
  // The bar is cut through, so the whole plane is.
  EXPECT_THAT(Slurp(folder_ / "out/report.html"), HasSubstr("middle</th><td>100</td><td>0.0</td>"));
  ExpectCut(nlohmann::json::parse(Slurp(folder_ / "out/assessment.json")));
  for (const char* file : {"report.html", "measures.csv", "planned.mrk.json", "achieved.mrk.json", "piece_1.stl",
                           "piece_2.stl", "transforms.json", "pieces.json", "overview.png", "cut.png"}) {
    EXPECT_TRUE(Exists(std::string("out/") + file)) << file;
  }
  // The achieved planes are used as the plan: the cut has no error relative to them.
  const ProgramResult again = Kerf("assess out/achieved.mrk.json --before run/bone.vdb --after run/bone.vdb --json");
  EXPECT_EQ(again.code, 0) << again.err;
  const auto uncut = nlohmann::json::parse(again.out)["planes"][0];  // nothing was cut between these two
  EXPECT_TRUE(uncut["cut"].is_null());
  EXPECT_EQ(uncut["reason"], "no bone was removed within 5 mm of it");
  const ProgramResult own = Kerf("assess s.toml --plan out/achieved.mrk.json --after run/bone.vdb --json");
  ASSERT_EQ(own.code, 0) << own.err;
  EXPECT_NEAR(nlohmann::json::parse(own.out)["planes"][0]["offset_mm"].get<double>(), 0, 1e-6);
  EXPECT_NEAR(nlohmann::json::parse(own.out)["planes"][0]["angle_deg"].get<double>(), 0, 1e-5);
}

TEST_F(AssessCommand, AssessesARecording) {
  const ProgramResult made = Kerf("loop s.toml --virtual --seconds 4 --record a.kerf");
  ASSERT_EQ(made.code, 0) << made.err;
  const ProgramResult result = Kerf("assess a.kerf --no-pictures -o out --json");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  ExpectCut(nlohmann::json::parse(result.out));
  EXPECT_EQ(result.out, Slurp(folder_ / "out/assessment.json"));
  const std::string html = Slurp(folder_ / "out/report.html");
  EXPECT_THAT(html, HasSubstr("Force on the hand"));
  EXPECT_THAT(html, HasSubstr("a.kerf"));
  EXPECT_FALSE(Exists("out/overview.png"));
}

// The lowest millimetre of the bar is a tooth.
TEST_F(AssessCommand, ListsTheStructuresThatAreCut) {
  const std::string layers =
      "[[bone.block.layer]]\nthickness_mm = 2\nregion = 24\n[[bone.block.layer]]\n"
      "thickness_mm = 1\nregion = 33\n";
  Write("teeth.toml", kScene + layers);
  const ProgramResult run = Kerf("run teeth.toml -o run");
  ASSERT_EQ(run.code, 0) << run.err;
  const ProgramResult text = Kerf("assess teeth.toml --after run/bone.vdb");
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out,
              testing::ContainsRegex("  .*t(oo|ee)th.*  (cut|cut through), [12]\\.[0-9]+ mm3 of it removed\n"));
  const auto json = nlohmann::json::parse(Kerf("assess teeth.toml --after run/bone.vdb --json").out);
  ASSERT_EQ(json["structures"].size(), 1U);
  EXPECT_EQ(json["structures"][0]["kind"], "tooth");
  EXPECT_NEAR(json["structures"][0]["removed_mm3"].get<double>(), 0.5 * 4 * 1, 0.4);
  EXPECT_TRUE(json["nerve_distance_mm"].is_null());
  EXPECT_EQ(json["pieces"].size(), 2U);
}

TEST_F(AssessCommand, AssessesRecordingsThatFollowEachOtherTogether) {
  ASSERT_EQ(Kerf("loop s.toml --virtual --seconds 4 --record a.kerf -o first").code, 0);
  // The second saw is twice as wide, and cuts 3 mm beside the first.
  Write("t.toml", "title = \"second\"\n[bone]\nfile = \"first/bone.vdb\"\n" + test::SawToml(14, 1, 16) +
                      "[force]\nlaw = \"hertz_chip\"\n" + test::StrokeToml({3, 0, 8.5}, {3, 0, 2.5}, 6, {1, 0, 0}) +
                      "[exercise]\nstart_mm = [3, 2, 0]\nend_mm = [3, -2, 0]\ninto = [0, 0, -1]\n"
                      "[output]\npictures = false\n");
  ASSERT_EQ(Kerf("loop t.toml --virtual --seconds 4 --record b.kerf").code, 0);
  const ProgramResult result = Kerf("assess b.kerf --before a.kerf --reach 1 --no-pictures -o out");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("bar; second"));
  EXPECT_THAT(result.out, HasSubstr("pieces            3"));
  const auto json = nlohmann::json::parse(Slurp(folder_ / "out/assessment.json"));
  ASSERT_EQ(json["planes"].size(), 2U);
  EXPECT_NEAR(json["planes"][0]["offset_mm"].get<double>(), 0.1, 0.1);
  EXPECT_NEAR(json["planes"][1]["cut"]["width_mm"].get<double>(), 1, 0.05);
  EXPECT_EQ(json["before_mm3"], nlohmann::json::parse(Kerf("assess a.kerf --json").out)["before_mm3"]);
  EXPECT_NEAR(json["removed_mm3"].get<double>(), 1.5 * 4 * 3, 0.5);
  const ProgramResult swapped = Kerf("assess a.kerf --before b.kerf");
  EXPECT_EQ(swapped.code, 1);
  EXPECT_THAT(swapped.err, HasSubstr("a.kerf: did not begin with the bone that the recording before it ended with"));
  EXPECT_EQ(Kerf("assess b.kerf --before first/bone.vdb").code, 2);
  EXPECT_EQ(Kerf("assess s.toml --before a.kerf --after first/bone.vdb").code, 2);
}

TEST_F(AssessCommand, WritesPlanesAndATableForSlicerAndReadsAFolderOfPlanes) {
  RunScene();
  std::filesystem::create_directory(folder_ / "planes");
  const ProgramResult result =
      Kerf("assess s.toml --after run/bone.vdb --markups planes/cut.mrk.json --table cut.csv --json");
  ASSERT_EQ(result.code, 0) << result.err;
  ExpectCut(nlohmann::json::parse(result.out));
  EXPECT_THAT(Slurp(folder_ / "cut.csv"), HasSubstr("subject,measure,unit,value\nmiddle,offset,mm,0."));
  const ProgramResult again = Kerf("assess s.toml --plan planes --after run/bone.vdb --json");
  ASSERT_EQ(again.code, 0) << again.err;
  const auto planes = nlohmann::json::parse(again.out)["planes"];
  ASSERT_EQ(planes.size(), 1U);  // what was cut is not planned
  EXPECT_THAT(again.err, HasSubstr("'middle, as cut' was cut, not planned, and is skipped"));
  EXPECT_EQ(planes[0]["name"], "middle");
  EXPECT_EQ(planes[0]["offset_mm"], nlohmann::json::parse(result.out)["planes"][0]["offset_mm"]);
  EXPECT_EQ(Kerf("assess s.toml --after run/bone.vdb --markups cut.json").code, 2);
  // Both files are checked before one is written.
  const ProgramResult no_table =
      Kerf("assess s.toml --after run/bone.vdb --markups alone.mrk.json --table missing/cut.csv");
  EXPECT_EQ(no_table.code, 1);
  EXPECT_THAT(no_table.err, HasSubstr("missing/cut.csv: can't be written"));
  EXPECT_FALSE(Exists("alone.mrk.json"));
  const ProgramResult over =
      Kerf("assess s.toml --plan planes/cut.mrk.json --after run/bone.vdb --markups planes/cut.mrk.json");
  EXPECT_EQ(over.code, 1);
  EXPECT_THAT(over.err, HasSubstr("cut.mrk.json"));
  // What is read from a folder, a scene or by the scene's file is an input, too.
  const std::string plane = Slurp(folder_ / "planes/cut.mrk.json");
  Write("case.mrml", "<MRML><S fileName=\"planes/cut.mrk.json\"/></MRML>");
  Write("plan.toml", Slurp(folder_ / "s.toml") + "[[plan.plane]]\nname = \"file\"\nfile = \"one.mrk.json\"\n");
  Write("one.mrk.json", Slurp(folder_ / "planes/cut.mrk.json"));
  for (const char* inputs :
       {"s.toml --plan planes --markups planes/cut.mrk.json", "s.toml --plan case.mrml --markups planes/cut.mrk.json",
        "s.toml --plan planes -o planes", "s.toml --table run/forces.csv --pieces run/forces.csv"}) {
    const ProgramResult refused = Kerf(fmt::format("assess {} --after run/bone.vdb", inputs));
    EXPECT_EQ(refused.code, 1) << inputs;
    EXPECT_THAT(refused.err,
                AnyOf(HasSubstr("is an input and would be overwritten"), HasSubstr("choose another output")));
  }
  EXPECT_EQ(Slurp(folder_ / "planes/cut.mrk.json"), plane);
  ASSERT_EQ(Kerf("model block -o whole.vdb --size 12,4,3 --voxel 0.2").code, 0);
  const ProgramResult swapped = Kerf("assess planes --before run/bone.vdb --after whole.vdb");
  EXPECT_EQ(swapped.code, 1);
  EXPECT_THAT(swapped.err, HasSubstr("they are swapped, or of different bones"));
}

TEST_F(AssessCommand, AppliesPositionsOfMovedPieces) {
  RunScene();
  ASSERT_EQ(Kerf("assess s.toml --after run/bone.vdb -o out --no-pictures").code, 0);
  auto json = nlohmann::json::parse(Slurp(folder_ / "out/pieces.json"));
  json["pieces"][1]["transform"][11] = 5.0;
  Write("moved.json", json.dump());
  const ProgramResult moved =
      Kerf("assess s.toml --after run/bone.vdb --pieces moved.json -o out2 --obj --no-pictures");
  ASSERT_EQ(moved.code, 0) << moved.err;
  EXPECT_TRUE(Exists("out2/piece_2_origin.obj"));
  EXPECT_TRUE(Exists("out2/piece_2.tfm"));
  EXPECT_THAT(Slurp(folder_ / "out2/measures.csv"), HasSubstr("piece 2,moved,mm,5\n"));
  // The planned move is applied, or compared with where the piece is; the kerf of 0.5 mm is the gap.
  const ProgramResult planned = Kerf("assess s.toml --after run/bone.vdb --move 3,0,-1.5,0,1,0");
  EXPECT_THAT(planned.out, HasSubstr("piece 2           planned move 1.00 mm; now 0.00 mm and 0.00 deg from there"));
  EXPECT_THAT(planned.out, HasSubstr("overlap with piece 1 0.0 mm3, least gap 0."));
  EXPECT_THAT(Kerf("assess s.toml --after run/bone.vdb --pieces moved.json --move 3,0,-1.5,0,0,3").out,
              HasSubstr("planned move 3.00 mm; now 2.00 mm"));
  const ProgramResult largest = Kerf("assess s.toml --after run/bone.vdb --move -3,0,-1.5,0,1,0");
  EXPECT_EQ(largest.code, 1);
  EXPECT_THAT(largest.err, HasSubstr("its point is in the largest piece, which stays"));
  EXPECT_EQ(Kerf("assess s.toml --after run/bone.vdb --move 9,9,9,0,1,0").code, 1);
  EXPECT_EQ(Kerf("assess s.toml --after run/bone.vdb --move 9,9").code, 2);
}

TEST_F(AssessCommand, ReportsMissingInput) {
  EXPECT_EQ(Kerf("assess").code, 2);
  EXPECT_EQ(Kerf("assess s.toml").code, 2);
  EXPECT_EQ(Kerf("assess s.toml --after x.vdb --margin 0").code, 2);
  const ProgramResult none = Kerf("assess s.toml --after none.vdb");
  EXPECT_EQ(none.code, 1);
  EXPECT_EQ(none.out, "");
  EXPECT_EQ(std::count(none.err.begin(), none.err.end(), '\n'), 1) << none.err;
  ASSERT_EQ(Kerf("run s.toml -o run --record r.kerf").code, 0);
  const ProgramResult run = Kerf("assess r.kerf");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("is a recording of 'kerf run'"));
}

}  // namespace
}  // namespace kerf
