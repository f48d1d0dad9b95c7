// Tests of kerf score and of the part of kerf practise without a window, run as programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using testing::HasSubstr;

const std::string kBar =
    test::BlockToml({12, 6, 6}, 0.25) + test::SawToml(12, 0.5, 16) +
    test::StrokeToml({-2, 0, 6.5}, {-2, 0, 4}, 4, {0, 1, 0}) +
    "[[path.stroke]]\nend_mm = [2.0, 0.0, 4.0]\nfeed_mm_per_s = 4.0\nretract = false\n[output]\npictures = false\n";
constexpr char kGroove[] =
    "[exercise]\nkind = \"groove\"\nstart_mm = [-2.0, 0.0, 0.0]\nend_mm = [2.0, 0.0, 0.0]\ninto = [0.0, 0.0, -1.0]\n"
    "depth_mm = 2.0\nfeed_mm_per_s = 4.0\n";

class Score : public test::ProgramTest {
 protected:
  Score() : ProgramTest({{"bar.toml", kBar}, {"groove.toml", kBar + kGroove}}) {}
  ProgramResult Practise(const std::string& arguments) const {
    return KerfWithin("export KERF_DATA=data;", "practise " + arguments);
  }
};

TEST_F(Score, OfAPerfectRunIsNearly100) {
  ASSERT_EQ(Kerf("run groove.toml -o out --record a.kerf").code, 0);
  const ProgramResult result = Kerf("score a.kerf --json -o a.html");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.err, "");
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["exercise"], "groove");
  EXPECT_GT(json["total"], 90);
  EXPECT_LT(std::abs(json["measures"]["plane_offset_mm"]["value"].get<double>()), 0.2);
  EXPECT_LT(json["measures"]["plane_angle_deg"]["value"], 0.4);
  EXPECT_LT(json["measures"]["depth_error_worst_mm"]["value"], 0.2);
  EXPECT_TRUE(Exists("a.html"));
  // The results are repeatable, and also available as rows.
  EXPECT_EQ(Kerf("score a.kerf --json").out, result.out);
  EXPECT_THAT(Kerf("score a.kerf --csv").out, HasSubstr("\ntotal,"));
  EXPECT_THAT(Kerf("score a.kerf").out, HasSubstr("of 100"));
}

TEST_F(Score, PractiseRefusesOptionsThatHaveNoUse) {
  for (const auto& [arguments, message] : {
           std::pair("--agent expert --exercise groove -o new", "kerf: -o: is only for the window"),
           std::pair("--list --size 800x600", "kerf: --size: is only for the window"),
           std::pair("--record new.kerf", "kerf: --record requires --agent"),
           std::pair("--list --keys keys.txt", "kerf: --keys requires --report"),
       }) {
    const ProgramResult result = Practise(arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_THAT(result.err, testing::StartsWith(message));
    EXPECT_FALSE(Exists("new"));
  }
}

TEST_F(Score, RecordingWithoutExerciseHasOnlyMeasuresThatNeedNoPlan) {
  ASSERT_EQ(Kerf("loop bar.toml --virtual --seconds 1.5 --record a.kerf").code, 0);
  const ProgramResult result = Kerf("score a.kerf --json");
  ASSERT_EQ(result.code, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_TRUE(json["exercise"].is_null());
  EXPECT_TRUE(json["total"].is_null());
  EXPECT_TRUE(json["measures"]["plane_offset_mm"]["value"].is_null());
  EXPECT_GT(json["measures"]["removed_mm3"]["value"], 0.1);
  EXPECT_GT(json["measures"]["force_peak_N"]["value"], 0);
  EXPECT_NEAR(json["measures"]["time_total_s"]["value"].get<double>(), 1.5, 0.002);
}

TEST_F(Score, RefusesInvalidRecordings) {
  Write("a.kerf", "nothing");
  EXPECT_EQ(Kerf("score a.kerf").code, 1);
  EXPECT_EQ(Kerf("score none.kerf").code, 1);
  EXPECT_EQ(Kerf("score").code, 2);
  EXPECT_EQ(Kerf("score a.kerf --json --csv").code, 2);
  EXPECT_THAT(Kerf("score --measures").out, HasSubstr("| `plane_offset_mm` |"));
}

// The recording names its bone, which is read and not written.
TEST_F(Score, DoesNotOverwriteTheRecordingOrItsBone) {
  ASSERT_EQ(Kerf("model block -o bone.vdb --size 12,6,6 --voxel 0.25").code, 0);
  Write("file.toml", "[bone]\nfile = \"bone.vdb\"\n" + kBar.substr(kBar.find("[tool]")));
  ASSERT_EQ(Kerf("loop file.toml --virtual --seconds 0.1 --record a.kerf").code, 0);
  for (const std::string& input : {std::string("bone.vdb"), std::string("a.kerf")}) {
    const std::string content = test::Slurp(folder_ / input);
    const ProgramResult result = Kerf("score a.kerf -o " + input);
    EXPECT_EQ(result.code, 1) << input;
    EXPECT_THAT(result.err, HasSubstr("is an input and would be overwritten by " + input));
    EXPECT_EQ(test::Slurp(folder_ / input), content);
  }
  EXPECT_EQ(Kerf("score a.kerf -o a.html").code, 0);
}

TEST_F(Score, AnAgentsRecordingIsHandedInAndListed) {
  ASSERT_EQ(Practise("--list").code, 0);
  EXPECT_THAT(Practise("--list").out, HasSubstr("stop_before_far"));
  int exercises = 0;  // the others are procedures, which have no difficulty
  for (const Json& one : Json::parse(Practise("--list --json").out)) exercises += one["difficulty"] > 0 ? 1 : 0;
  EXPECT_EQ(exercises, 6);
  const ProgramResult did = Practise("--agent expert --exercise groove --level 3 --seconds 4 --record a.kerf");
  ASSERT_EQ(did.code, 0) << did.err;
  EXPECT_THAT(did.err, HasSubstr("did not finish within"));
  ASSERT_EQ(Practise("--hand-in a.kerf --student Ida").code, 0);
  const ProgramResult again = Practise("--hand-in a.kerf --student Ida");
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.err, HasSubstr("before"));
  const Json history = Json::parse(Practise("--history --json").out);
  ASSERT_EQ(history.size(), 1U);
  EXPECT_EQ(history[0]["student"], "Ida");
  EXPECT_EQ(history[0]["exercise"], "groove");
  EXPECT_EQ(history[0]["level"], 3);
  const std::string csv = Practise("--history --student Ole --csv").out;
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1);
  ASSERT_EQ(Practise("--report page.html").code, 0);
  EXPECT_TRUE(Exists("page.html"));
}

TEST_F(Score, IncompleteAndDuplicateSubmissionsAreMarkedEverywhere) {
  ASSERT_EQ(Kerf("run groove.toml -o out --record a.kerf").code, 0);
  const std::string bytes = test::Slurp(folder_ / "a.kerf");
  Write("cut.kerf", bytes.substr(0, bytes.size() / 2));
  Write("copy.kerf", bytes);
  const ProgramResult cut = Kerf("score cut.kerf --json");
  EXPECT_EQ(cut.code, 3) << cut.err;
  const Json sheet = Json::parse(cut.out);
  EXPECT_EQ(sheet["complete"], false);
  EXPECT_EQ(sheet["recording_state"], "cut short");
  EXPECT_TRUE(sheet["total"].is_null());
  EXPECT_EQ(sheet["incomplete"][0], "the recording is cut short");
  EXPECT_EQ(Json::parse(Kerf("score a.kerf --json").out)["complete"], true);

  EXPECT_EQ(Practise("--hand-in a.kerf --student Ida").code, 0);
  const ProgramResult doubled = Practise("--hand-in copy.kerf --student =Ole");
  EXPECT_EQ(doubled.code, 0);
  EXPECT_THAT(doubled.err, HasSubstr("copy.kerf: marked: same recording or beginning as number 1"));
  EXPECT_EQ(Practise("--hand-in cut.kerf --student Ida").code, 3);
  const Json history = Json::parse(Practise("--history --json").out);
  ASSERT_EQ(history.size(), 3U);
  EXPECT_EQ(history[0]["doubles"], Json({2}));
  EXPECT_EQ(history[1]["doubles"], Json({1}));
  EXPECT_TRUE(history[2]["total"].is_null());
  EXPECT_EQ(history[2]["recording_state"], "cut short");
  EXPECT_THAT(Practise("--history").out, HasSubstr("not graded: the recording is cut short"));
  EXPECT_THAT(Practise("--history --csv").out, HasSubstr("\n2,'=Ole,"));
  ASSERT_EQ(Practise("--report page.html").code, 0);
  const std::string page = test::Slurp(folder_ / "page.html");
  EXPECT_THAT(page, HasSubstr("3 of them are marked"));
  EXPECT_THAT(page, HasSubstr("same recording or beginning as number 2"));
  EXPECT_THAT(page, HasSubstr("not graded: the recording is cut short"));
}

// If it were graded, a student could repeat the last part until the total is good.
TEST_F(Score, ContinuedRecordingIsNotGraded) {
  ASSERT_EQ(Practise("--agent novice --exercise groove --seconds 4 --record a.kerf").code, 0);
  ASSERT_EQ(Kerf("loop --from a.kerf --at 3.5 --seconds 0.01 --virtual --record b.kerf").code, 0);
  const ProgramResult result = Kerf("score b.kerf --json");
  EXPECT_EQ(result.code, 0) << result.err;
  const Json sheet = Json::parse(result.out);
  EXPECT_TRUE(sheet["total"].is_null());
  EXPECT_THAT(sheet["incomplete"].dump(), HasSubstr("it continues another recording"));
  ASSERT_EQ(Practise("--hand-in a.kerf --student Ida").code, 0);
  const ProgramResult handed = Practise("--hand-in b.kerf --student Eve");
  EXPECT_THAT(handed.err, HasSubstr("marked: not graded: it continues another recording"));
  EXPECT_THAT(handed.err, HasSubstr("marked: same recording or beginning as number 1"));
  const Json history = Json::parse(Practise("--history --json").out);
  EXPECT_TRUE(history[1]["total"].is_null());
  EXPECT_EQ(history[1]["doubles"], Json({1}));
  ASSERT_EQ(Practise("--report page.html").code, 0);
  EXPECT_THAT(test::Slurp(folder_ / "page.html"), HasSubstr("it continues another recording"));
}

TEST_F(Score, ATitleDoesNotControlTheTerminal) {
  Write("evil.toml", "title = \"a\\u009b2J\\u202eb\"\n" + kBar + kGroove);
  ASSERT_EQ(Kerf("run evil.toml -o out --record a.kerf").code, 0);
  for (const char* arguments : {"check evil.toml", "score a.kerf", "loop evil.toml --virtual --seconds 0.01"}) {
    EXPECT_THAT(Kerf(arguments).out, HasSubstr("a?2J?b")) << arguments;
  }
}

TEST_F(Score, AStudentsNameIsUtf8) {
  // The names contain a byte that is never valid, an overlong form of "/", half of a surrogate pair, and a truncated
  // character.
  for (const char* name : {"'\xff'", "'\xc0\xaf'", "'\xed\xa0\x80'", "'Ja\xc3'"}) {
    for (const char* more : {"--hand-in groove.toml", "--history --csv"}) {
      const ProgramResult refused = Practise(std::string(more) + " --student " + name);
      ExpectRefusal(refused, "the student's name contains control characters, or is not UTF-8");
    }
  }
  const ProgramResult taken = Practise("--history --csv --student 'J\xc3\xb8rgen'");
  EXPECT_EQ(taken.code, 0) << taken.err;
}

TEST_F(Score, PractiseRefusesInvalidInput) {
  EXPECT_EQ(Practise("--hand-in a.kerf").code, 2);
  EXPECT_EQ(Practise("--agent expert").code, 2);
  EXPECT_EQ(Practise("--agent master --exercise groove").code, 1);
  EXPECT_EQ(Practise("--agent expert --exercise juggling").code, 1);
  EXPECT_EQ(Practise("--agent expert --exercise groove --level 6").code, 2);
  EXPECT_EQ(Practise("--hand-in none.kerf --student Ida").code, 1);
}

}  // namespace
}  // namespace kerf
