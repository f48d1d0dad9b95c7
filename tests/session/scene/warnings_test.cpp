// Tests of warnings about valid scenes.
#include "session/scene/warnings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "cut/force/measured.h"
#include "scene_text.h"

namespace kerf {
namespace {

/// Returns the warnings of a scene whose bite is `bite_um` at 3000 teeth per second.
std::string WarningsAt(double bite_um, const std::string& law) {
  const std::string text = "[bone]\nmodel = \"block\"\n[[path.stroke]]\nstart_mm = [0, 0, 0]\nend_mm = [1, 0, 0]\n" +
                           fmt::format("feed_mm_per_s = {}\ndisc_normal = [0, 1, 0]\n", bite_um * 3) +
                           fmt::format("[force]\nlaw = \"{}\"\n", law);
  std::string all;
  for (const std::string& warning : FindWarnings(ParseScene(text, "s.toml"), 0.1)) all += warning + "\n";
  return all;
}

TEST(Doubts, BiteIsCheckedAgainstTheChosenLawsRange) {
  EXPECT_EQ(WarningsAt(2.9, "hertz_chip"), "");
  EXPECT_EQ(
      WarningsAt(6, "hertz_chip"),
      "the bite reaches 6 um: hertz_chip holds up to about 3 um, beyond it gives more than twice the measured thrust; "
      "feed more slowly or turn faster\n");
  for (const double bite_um : {0.1, 200.0}) {
    EXPECT_EQ(
        WarningsAt(bite_um, "hertz_constant_bite"),
        "hertz_constant_bite gives the same force regardless of the bite: thrust 1/122 of that measured at a bite of "
        "2.5 um, 1/168 of that at 10 um (22 mm disc with 24 teeth); nothing was measured below 2 um\n");
  }
  EXPECT_EQ(WarningsAt(6, "edge_plus_chip"), "");
  EXPECT_EQ(WarningsAt(1, "edge_plus_chip"),
            "the bite stays at or below 1 um: edge_plus_chip holds from about 2.5 um, below that the edge term is an "
            "extrapolation\n");
  EXPECT_EQ(WarningsAt(12, "edge_plus_chip"),
            "the bite reaches 12 um: edge_plus_chip holds up to about 10 um, beyond that the chip term is an "
            "extrapolation\n");
}

// The range of a table is that of its rows, and osteons are of no use to an isotropic law.
TEST(Doubts, FollowTheTableAndTheLaw) {
  Scene scene = ParseScene(test::ShortScene() + "[material]\nosteon_direction = [1, 0, 0]\n", "s.toml");
  scene.path.strokes[0].feed_mm_per_s = 6;  // 2 um
  EXPECT_THAT(FindWarnings(scene, 0.1),
              testing::Contains("osteon_direction is not used: the law hertz_chip is isotropic"));
  scene.force = ForceLaw("two_component");
  EXPECT_THAT(FindWarnings(scene, 0.1), testing::Not(testing::Contains(testing::HasSubstr("osteon_direction"))));
  scene.material.osteon_direction.reset();
  scene.force = ForceLaw("tabulated");
  EXPECT_THAT(FindWarnings(scene, 0.1), testing::Contains(testing::HasSubstr("tabulated holds from about 2.5 um")));
  scene.force.SetTable(std::make_shared<const ForceTable>(
      ParseForceTable("tissue,bite_um,thrust_N_per_mm,cutting_N_per_mm,source\ncortical,1,4,3,t\ncortical,3,5,3,t\n"
                      "cancellous,1.5,4,3,t\ncancellous,2.5,5,3,t\n",
                      "t.csv")));
  EXPECT_EQ(FindMinValidBite(scene.force), 0.001);
  EXPECT_EQ(FindMaxValidBite(scene.force, MakeTool(scene)), 0.003);
  EXPECT_THAT(FindWarnings(scene, 0.1), testing::Not(testing::Contains(testing::HasSubstr("holds from"))));
}

TEST(Doubts, VoxelsAndSamplesOfTheRimFollowTheBlade) {
  DiscSaw disc;
  disc.teeth = 20;
  disc.diameter_mm = 60;  // a pitch of 9.42 mm
  SimulationParams params;
  params.tool = disc;
  params.rim_samples_per_pitch = 4;
  EXPECT_THAT(
      FindVoxelWarnings(params, 0.1),
      testing::ElementsAre("the rim samples the bone only every 2.36 mm (teeth = 20 times rim_samples_per_pitch = 4): "
                           "the force changes in steps; give rim_samples_per_pitch = 10"));
  params.rim_samples_per_pitch = 16;
  EXPECT_THAT(FindVoxelWarnings(params, 0.125), testing::IsEmpty());
  EXPECT_THAT(FindVoxelWarnings(params, 0.2),
              testing::ElementsAre(
                  testing::HasSubstr("the disc is 1.25 voxels thick (thickness_mm = 0.25, voxels of 0.2 mm)")));
  EXPECT_THAT(FindVoxelWarnings(params, 0.3),
              testing::ElementsAre(testing::HasSubstr("the disc is thinner than a voxel (thickness_mm = 0.25")));
  params.tool = BallBurr{};
  EXPECT_THAT(FindVoxelWarnings(params, 2), testing::IsEmpty());
}

TEST(Doubts, EveryLawWarnsJustOutsideItsRangeAndNotInside) {
  for (const ForceLawInfo* law : ForceLaws()) {
    if (IsNowhereMeasured(law->validity)) continue;
    const double from_um = 1000 * law->validity.from_mm;
    const double to_um = std::min(1000 * law->validity.to_mm, 300.0);
    EXPECT_EQ(WarningsAt(std::max(from_um * 1.01, 0.01), law->name), "") << law->name;
    EXPECT_EQ(WarningsAt(to_um * 0.99, law->name), "") << law->name;
    if (from_um > 0) {
      EXPECT_NE(WarningsAt(from_um * 0.99, law->name), "") << law->name;
    }
    if (to_um < 300) {
      EXPECT_NE(WarningsAt(to_um * 1.01, law->name), "") << law->name;
    }
  }
}

}  // namespace
}  // namespace kerf
