// Tests of the scene reader's error messages: position, fault, and remedy.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <ostream>

#include "scene_text.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Mistake {
  const char* name;
  std::string text;
  std::string message;

  friend void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.name; }
};

class SceneMessage : public ::testing::TestWithParam<Mistake> {};

TEST_P(SceneMessage, IsExactlyAsExpected) {
  EXPECT_EQ(test::MessageFor(GetParam().text), GetParam().message);
}

const std::string kTail =
    "[[path.stroke]]\nstart_mm = [0,0,0]\nend_mm = [1,0,0]\nfeed_mm_per_s = 3\ndisc_normal = [0,1,0]\n";

/// A row of the force law's table.
std::string ForceRow(double bite_um, double thrust_N_per_mm) {
  return fmt::format(
      "[[force.row]]\ntissue = \"cortical\"\nbite_um = {}\nthrust_N_per_mm = {}\ncutting_N_per_mm = 1\nsource = "
      "\"t\"\n",
      bite_um, thrust_N_per_mm);
}

INSTANTIATE_TEST_SUITE_P(
    All, SceneMessage,
    ::testing::Values(
        Mistake{"UnknownKey", test::ShortScene() + "[tool]\n  diamter_mm = 22\n",
                "s.toml:9:3: unknown key \"diamter_mm\" in [tool]; the nearest valid key is \"diameter_mm\""},
        Mistake{"UnknownTable", test::ShortScene() + "[tol]\nteeth = 3\n",
                "s.toml:8:2: unknown key \"tol\" in the scene; the nearest valid key is \"tool\""},
        Mistake{"KeyWithoutItsUnit", test::ShortScene() + "[tool]\nthickness = 1\n",
                "s.toml:9:1: unknown key \"thickness\" in [tool]; the nearest valid key is \"thickness_mm\""},
        Mistake{"UnknownKeyInStroke", test::ShortScene() + "speed = 3\n",
                "s.toml:8:1: unknown key \"speed\" in [[path.stroke]]; valid keys: start_mm, end_mm, feed_mm_per_s, "
                "disc_normal, dwell_s, "
                "retract"},
        Mistake{"UnknownDevice", test::ShortScene() + "[device]\nprofile = \"omega_66\"\n",
                "s.toml:9:1: device \"omega_66\" is unknown; the nearest is \"omega_6\""},
        Mistake{"UnknownHand", test::ShortScene() + "[hand]\nmodel = \"H7\"\n",
                "s.toml:9:1: model = \"H7\" is unknown; it must be \"H0\" or \"H1\" or \"H2\" or \"H3\" or \"H4\""},
        Mistake{"DeviceTableWithoutAName", test::ShortScene() + "[device]\nfile = \"profiles.csv\"\n",
                "s.toml:8:2: [device] has no profile"},
        Mistake{"NegativeThickness", test::ShortScene() + "[tool]\nthickness_mm = -0.1\n",
                "s.toml:9:1: thickness_mm = -0.1 is below 0.02; valid range 0.02 to 10 mm"},
        Mistake{"TextForNumber", test::ShortScene() + "[tool]\nrpm = \"fast\"\n",
                "s.toml:9:1: rpm = \"fast\" is a string; it must be a number from 1 to 100000 rpm, or 0"},
        Mistake{"DateForNumber", test::ShortScene() + "[tool]\nrpm = 2026-11-20\n",
                "s.toml:9:1: rpm is a date or time; it must be a number from 1 to 100000 rpm, or 0"},
        Mistake{"NaNInVector", test::ShortScene() + "[tool]\ngrip_mm = [0, nan, 80]\n",
                "s.toml:9:15: grip_mm[1] = nan is not a finite number; valid range -1000 to 1000 mm"},
        Mistake{
            "TextInVector", test::ShortScene() + "[tool]\ngrip_mm = [0, 0, \"z\"]\n",
            "s.toml:9:18: grip_mm[2] = \"z\" is a string; grip_mm must be a list of three numbers [x, y, z] from -1000 "
            "to 1000 mm"},
        Mistake{"KeyOfAnotherTool", test::ShortScene() + "[tool]\nshape = \"ball\"\nteeth = 24\n",
                "s.toml:10:1: teeth is not used: shape is \"ball\"; remove it"},
        Mistake{"SenseOfAStroke", test::ShortScene() + "[tool]\nshape = \"piezo\"\nreverse = true\n",
                "s.toml:10:1: reverse is not used: shape is \"piezo\"; remove it"},
        Mistake{"SlabOfABall", test::ShortScene() + "[tool]\nshape = \"ball\"\n[simulation]\nmode = \"slab\"\n",
                "s.toml:10:2: slab mode requires a disc, but [tool] shape is \"ball\""},
        Mistake{"KeyOfAnotherLaw", test::ShortScene() + "[force]\ncontact_share_of_pitch = 0.02\n",
                "s.toml:9:1: contact_share_of_pitch is not used: it belongs to hertz_constant_bite, and the law is "
                "two_component; remove it"},
        Mistake{"DensityKeyWithoutItsExponent", test::ShortScene() + "[force]\nmodulus_exponent = 1\n",
                "s.toml:9:1: modulus_exponent is not used without density_exponent; remove it"},
        Mistake{
            "KeyOfTwoOtherLaws", test::ShortScene() + "[force]\nlaw = \"hertz_chip\"\ndensity_exponent = 1\n",
            "s.toml:10:1: density_exponent is not used: it belongs to two_component and edge_plus_chip, and the law "
            "is hertz_chip; remove it"},
        Mistake{"UnknownLaw", test::ShortScene() + "[force]\nedge_N_per_mm = 3\nlaw = \"edge\"\n",
                "s.toml:10:1: law = \"edge\" is unknown; it must be \"two_component\" or \"hertz_chip\" or "
                "\"hertz_constant_bite\" or \"edge_plus_chip\" or \"tabulated\""},
        Mistake{"RatioOfALawWithCuttingForce",
                test::ShortScene() + "[force]\nlaw = \"two_component\"\n[effects.tangential_force]\nratio = 1.6\n",
                "s.toml:11:1: ratio is not used: the law two_component states the cutting force; remove it"},
        Mistake{
            "ShareOfALawWithCuttingForce",
            test::ShortScene() + "[force]\nlaw = \"tabulated\"\n[effects.tooth_vibration]\ntangential_share = 0.5\n",
            "s.toml:11:1: tangential_share is not used: the law tabulated states the cutting force; remove it"},
        Mistake{"TableOfAnotherLaw", test::ShortScene() + "[force]\nlaw = \"two_component\"\nfile = \"t.csv\"\n",
                "s.toml:10:1: file is not used: the law two_component reads no table; remove it"},
        Mistake{"RowOfAnotherLaw", test::ShortScene() + "[[force.row]]\ntissue = \"tooth\"\n",
                "s.toml:8:9: row is not used: the law two_component reads no table; remove it"},
        Mistake{"RowsOutOfOrder",
                test::ShortScene() + "[force]\nlaw = \"tabulated\"\n" + ForceRow(2, 5) + ForceRow(1, 6),
                "s.toml:16:1: the bites of cortical must increase from row to row, by at least 1 %"},
        Mistake{"OneRow", test::ShortScene() + "[force]\nlaw = \"tabulated\"\n" + ForceRow(2, 5),
                "s.toml:10:9: there is one row for cortical; at least two bites are needed"},
        Mistake{"RowWithoutSource",
                test::ShortScene() + "[force]\nlaw = \"tabulated\"\n[[force.row]]\ntissue = \"tooth\"\nbite_um = 0\n"
                                     "thrust_N_per_mm = 1\ncutting_N_per_mm = 1\n",
                "s.toml:10:1: [[force.row]] has no source\n"
                "s.toml:12:1: bite_um = 0 is below 0.001; valid range 0.001 to 1000 um"},
        Mistake{"OsteonsWithoutDirection", test::ShortScene() + "[material]\nosteon_direction = [0, 0, 0]\n",
                "s.toml:9:1: osteon_direction has length 0"},
        Mistake{"NoBone", kTail, "s.toml:1:1: the scene has no bone"},
        Mistake{"NoPath", "[bone]\nmodel = \"block\"\n", "s.toml:1:1: the scene has no path"},
        Mistake{"EmptyPath", "[bone]\nmodel = \"block\"\n[path]\n",
                "s.toml:3:2: [path] has neither [[path.stroke]] nor file"},
        Mistake{"NoStrokes", "[bone]\nmodel = \"block\"\n[path]\nstroke = []\n",
                "s.toml:4:1: [path] has neither [[path.stroke]] nor file"},
        Mistake{"MissingKeys", "[bone]\nmodel = \"block\"\n[[path.stroke]]\nend_mm = [1,0,0]\n",
                "s.toml:3:1: [[path.stroke]] has no feed_mm_per_s\n"
                "s.toml:3:1: [[path.stroke]] has no start_mm\n"
                "s.toml:3:1: [[path.stroke]] has no disc_normal"},
        Mistake{"UnknownModel", "[bone]\nmodel = \"femur\"\n" + kTail,
                "s.toml:2:1: model = \"femur\" is unknown; it must be \"mandible\" or \"block\" or \"plate\""},
        Mistake{"NeitherFileNorModel", "[bone]\n" + kTail,
                "s.toml:1:2: [bone] has neither file (a .vdb) nor model (\"mandible\" or \"block\" or \"plate\")"},
        Mistake{"FileAndModel", "[bone]\nfile = \"a.vdb\"\nmodel = \"block\"\n" + kTail,
                "s.toml:3:1: [bone] has both file and model; keep one of them"},
        Mistake{"FileAndStrokes", "[bone]\nmodel = \"block\"\n[path]\nfile = \"p.csv\"\n" + kTail,
                "s.toml:4:1: [path] has both file and stroke; keep one of them"},
        Mistake{"ParametersOfAnotherModel", "[bone]\nmodel = \"block\"\n[bone.plate]\nvoxel_mm = 0.1\n" + kTail,
                "s.toml:3:7: [bone.plate] is not used: the bone is model = \"block\"; remove it"},
        Mistake{"EmptyFileName", "[bone]\nfile = \"\"\n" + kTail, "s.toml:2:1: file is empty"},
        Mistake{"StrokeOfNoLength",
                "[bone]\nmodel = \"block\"\n[[path.stroke]]\nstart_mm = [1,0,0]\nend_mm = [1,0,0]\nfeed_mm_per_s = 3\n"
                "disc_normal = [0,1,0]\n",
                "s.toml:5:1: the stroke ends where it starts and has no dwell_s; move end_mm or give dwell_s"},
        Mistake{"NormalOfNoLength",
                "[bone]\nmodel = \"block\"\n[[path.stroke]]\nstart_mm = [0,0,0]\nend_mm = [1,0,0]\nfeed_mm_per_s = 3\n"
                "disc_normal = [0,0,0]\n",
                "s.toml:7:1: disc_normal has no direction: its length is 0"},
        Mistake{"GoesOnFromNothing", test::ShortScene() + "retract = false\n",
                "s.toml:8:1: retract = false in the first stroke; there is no previous stroke to continue"},
        Mistake{"GoesOnFromElsewhere",
                test::ShortScene() + "[[path.stroke]]\nretract = false\nstart_mm = [1, 0, 0.1]\nend_mm = [2, 0, 0]\n"
                                     "feed_mm_per_s = 1\ndisc_normal = [0, 2, 0.1]\n",
                "s.toml:10:1: start_mm is not where the previous stroke ends, and retract = false; omit start_mm or "
                "retract\ns.toml:13:1: disc_normal differs from the previous stroke's, and retract = false; omit "
                "disc_normal or retract"},
        Mistake{"TooLong",
                "[bone]\nmodel = \"block\"\n[[path.stroke]]\nstart_mm = [0,0,0]\nend_mm = [100,0,0]\n"
                "feed_mm_per_s = 0.001\ndisc_normal = [0,1,0]\n",
                "s.toml:3:8: the strokes take 100000 s; at most 36000 s"},
        Mistake{"StrokeIsATable", "[bone]\nmodel = \"block\"\n[path.stroke]\nend_mm = [1,0,0]\n",
                "s.toml:3:7: stroke is a table; it must be a list of tables"},
        Mistake{
            "TwiceTheSameKey", test::ShortScene() + "[tool]\nrpm = 1\nrpm = 2\n",
            "s.toml:10:7: not valid TOML: Error while parsing key-value pair: cannot redefine existing integer 'rpm'"}),
    [](const auto& test) { return test.param.name; });

TEST(SceneMessages, EveryFaultIsReportedInFileOrder) {
  const std::string message = test::MessageFor(
      "[output]\npictures = 1\n[tool]\nnu = 0.6\nteeth = 0\n[bone]\nmodel = \"block\"\n[bone.block]\nvoxel_mm = 0\n"
      "[[path.stroke]]\nstart_mm = [0,0]\n[force]\nlow = \"x\"\n");
  EXPECT_EQ(
      message,
      "s.toml:2:1: pictures = 1 is a number; it must be true or false\n"
      "s.toml:4:1: nu = 0.6 is above 0.5; valid range 0 to 0.5\n"
      "s.toml:5:1: teeth = 0 is below 1; valid range 1 to 1000\n"
      "s.toml:9:1: voxel_mm = 0 is below 0.02; valid range 0.02 to 4 mm\n"
      "s.toml:10:1: [[path.stroke]] has no end_mm\n"
      "s.toml:10:1: [[path.stroke]] has no feed_mm_per_s\n"
      "s.toml:10:1: [[path.stroke]] has no disc_normal\n"
      "s.toml:11:1: start_mm has 2 items; it must be a list of three numbers [x, y, z] from -1000000 to 1000000 mm\n"
      "s.toml:13:1: unknown key \"low\" in [force]; the nearest valid key is \"law\"");
}

TEST(SceneMessages, ManyFaultsAreCutOffWithACount) {
  std::string text = test::ShortScene() + "[tool]\n";
  for (int i = 0; i < 300; ++i) text += fmt::format("a{} = 1\n", i);
  const std::string message = test::MessageFor(text);
  EXPECT_EQ(std::count(message.begin(), message.end(), '\n'), 50);
  EXPECT_THAT(message, HasSubstr("s.toml: and 250 more faults"));
}

TEST(SceneMessages, TooManyStrokesAreRefused) {
  std::string text = "[bone]\nmodel = \"block\"\n[path]\nstroke = [\n";
  for (int i = 0; i < 1001; ++i) text += "{},";
  EXPECT_EQ(test::MessageFor(text + "]\n"), "s.toml:4:1: 1001 tables 'stroke'; at most 1000 are allowed");
}

TEST(SceneMessages, TooLargeTextIsRefusedBeforeParsing) {
  EXPECT_EQ(test::MessageFor(std::string(4194305, '#')), "s.toml: 4194305 bytes; a scene has at most 4194304");
}

TEST(SceneMessages, DeepNestingIsRefused) {
  EXPECT_THAT(test::MessageFor("a = " + std::string(100000, '[')), StartsWith("s.toml:1:"));
}

std::string DottedKey(int parts) {
  std::string key = "a";
  for (int part = 1; part < parts; ++part) key += ".a";
  return key;
}

TEST(SceneMessages, VeryLongDottedKeyIsRefusedAnywhere) {
  const std::string key = DottedKey(100000);
  const std::string what = ": the key has more than 16 parts joined by dots; no scene key is that long";
  EXPECT_EQ(test::MessageFor(key + "=1\n"), "s.toml:1:1" + what);
  EXPECT_EQ(test::MessageFor("\n[" + key + "]\n"), "s.toml:2:2" + what);
  EXPECT_EQ(test::MessageFor("[[" + key + "]]\n"), "s.toml:1:3" + what);
  EXPECT_EQ(test::MessageFor("x = {y = 1.5, " + key + " = 1}\n"), "s.toml:1:15" + what);
  // Blanks and quoted parts belong to the key.
  std::string quoted = "'a'";
  for (int part = 1; part < 100000; ++part) quoted += part % 2 == 0 ? ". 'b.#'" : " .\t\"\\\"\"";
  EXPECT_EQ(test::MessageFor("  " + quoted + " = 1\n"), "s.toml:1:3" + what);
  // Quotes within strings and comments, and two-byte characters, do not confuse the scan.
  EXPECT_EQ(
      test::MessageFor("t = \"\"\"\n# ' \\\"\"\"\"\"\"\nu = 'it' # \"'\nv = {\"\xc3\xa9\" = '''\\'''', " + key + "=1}"),
      "s.toml:4:22" + what);
}

TEST(SceneMessages, DotsOutsideKeysAreNotCounted) {
  const std::string dots(1000, '.');
  std::string list = "[0.5";
  for (int n = 0; n < 1000; ++n) list += ", 0.5";
  const std::string text = "# " + dots + "\nt = \"" + dots + "\"\nu = '''\n" + dots + "\n'''\nv = " + list + "]\n";
  EXPECT_THAT(test::MessageFor(text), ::testing::AllOf(HasSubstr("unknown key \"t\""), HasSubstr("unknown key \"v\"")));
  EXPECT_THAT(test::MessageFor(DottedKey(16) + " = 1\n"), HasSubstr("unknown key \"a\""));
  EXPECT_THAT(test::MessageFor(DottedKey(17) + " = 1\n"), HasSubstr("more than 16 parts"));
}

TEST(SceneMessages, NestedLongKeysAreRefused) {
  // toml++ limits the nesting of values, not the parts of their keys: it accepts 250 levels with 16 parts each.
  for (const std::size_t depth : {10u, 100u, 250u, 300u, 3000u}) {
    std::string text = fmt::format("[{}]\nx = [", DottedKey(16));
    for (std::size_t n = 0; n < depth; ++n) text += fmt::format("{{{} =\t", DottedKey(16));
    const std::string message = test::MessageFor(text + "1" + std::string(depth, '}') + "]\n");
    EXPECT_THAT(message, StartsWith("s.toml:2:")) << depth;
    if (depth <= 250) {
      EXPECT_THAT(message, HasSubstr("nested more than 64 deep; no scene needs that")) << depth;
    }
  }
  EXPECT_THAT(test::MessageFor("a = " + std::string(60, '[') + std::string(60, ']') + "\n"),
              HasSubstr("unknown key \"a\""));
}

TEST(SceneMessages, BytesThatAreNotUtf8AreRefused) {
  EXPECT_THAT(test::MessageFor("title = \"\xff\xfe\"\n"), StartsWith("s.toml:1:"));
}

}  // namespace
}  // namespace kerf
