// Scenes with a reciprocating blade: what they refuse, and their warnings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cut/tool/drive.h"
#include "scene_text.h"
#include "session/scene/warnings.h"

namespace kerf {
namespace {

const std::string kBlade = "[tool]\nshape = \"reciprocating\"\n";

TEST(StrokeScene, RefusesWhatIsForToolsThatTurn) {
  EXPECT_EQ(test::MessageFor(test::ShortScene() + kBlade), "");
  EXPECT_THAT(test::MessageFor(test::ShortScene() + kBlade + "[slab]\nwidth_mm = 5\n"),
              testing::HasSubstr("slab mode requires a disc"));
  EXPECT_EQ(test::MessageFor(test::ShortScene() + kBlade + "[effects.tangential_force]\n[effects.heat]\n"), "");
}

TEST(StrokeScene, HasExercisesAndPlansButFollowsNoLine) {
  for (const char* shape : {"reciprocating", "oscillating", "piezo"}) {
    const std::string scene = test::ShortScene() + "[tool]\nshape = \"" + shape + "\"\n";
    EXPECT_EQ(test::MessageFor(scene + "[plan]\n[exercise]\nkind = \"osteotomy\"\n"), "");
    EXPECT_THAT(test::MessageFor(scene + "[exercise]\nkind = \"follow_line\"\n"),
                testing::HasSubstr("the kind \"follow_line\" requires a tool that turns"));
  }
}

TEST(ToolScene, ValuesThatDoNotFitTogetherAreNamedWithTheirPlace) {
  EXPECT_THAT(
      test::MessageFor(test::ShortScene() + "[tool]\nshape = \"drill\"\nlength_mm = 0.5\npoint_angle_deg = 60\n"),
      testing::HasSubstr("length_mm = 0.5 is too short for point_angle_deg = 60 and diameter_mm = 1.5: the tip "
                         "alone is 1.3 mm long"));
}

TEST(StrokeScene, WarnsAboutAStrokeShorterThanThePitchAndANarrowKerf) {
  Scene scene = ParseScene(test::ShortScene() + kBlade, "s.toml");
  const auto has = [&](const char* text, double voxel_mm) {
    const std::vector<std::string> warnings = FindWarnings(scene, voxel_mm);
    return std::any_of(warnings.begin(), warnings.end(),
                       [&](const std::string& w) { return w.find(text) != std::string::npos; });
  };
  EXPECT_FALSE(has("the stroke is shorter", 0.1));
  EXPECT_FALSE(has("the kerf of the blade", 0.1));
  EXPECT_TRUE(has("the kerf of the blade is 0.5 voxels wide", 1));
  std::get<ReciprocatingBlade>(scene.tool.shape).stroke_mm = 1;
  EXPECT_TRUE(has("the stroke is shorter than the pitch (1 mm, pitch_mm = 1.41)", 0.1));
}

TEST(StrokeScene, LargestBiteIsThatOfTheTurnOfTheToothInFront) {
  // Half a stroke of 3 mm and a pitch of 1.5 mm: the tooth in front turns a quarter of a period after the tooth's turn.
  const Scene scene =
      ParseScene(test::ShortScene() + kBlade + "pitch_mm = 1.5\nrpm = 6000\n", "s.toml");  // a period of 10 ms
  EXPECT_NEAR(CalcMaxBite(scene), 3 * 2 * 0.0025, 1e-12);
}

}  // namespace
}  // namespace kerf
