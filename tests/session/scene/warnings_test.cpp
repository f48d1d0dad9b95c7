// Tests of warnings about valid scenes.
#include "session/scene/warnings.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
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
      "the bite reaches 6 um: hertz_chip holds from about 2 to 3 um, beyond it gives more than twice the measured "
      "thrust; feed more slowly or turn faster\n");
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
            "the bite reaches 12 um: edge_plus_chip holds from about 2.5 to 10 um, beyond that the chip term is an "
            "extrapolation\n");
}

// The range of a table is that of its rows, and osteons are of no use to an isotropic law.
TEST(Doubts, FollowTheTableAndTheLaw) {
  Scene scene = ParseScene(test::ShortScene() + "[material]\nosteon_direction = [1, 0, 0]\n", "s.toml");
  scene.path.strokes[0].feed_mm_per_s = 6;  // 2 um
  scene.force = ForceLaw("hertz_chip");
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
}

TEST(Doubts, BallsBursAndDrillsNeedThreeVoxels) {
  SimulationParams params;
  params.tool = TwistDrill{.diameter_mm = 0.5};
  EXPECT_THAT(FindVoxelWarnings(params, 0.166), testing::IsEmpty());
  EXPECT_THAT(FindVoxelWarnings(params, 0.2),
              testing::ElementsAre("the drill is 2.5 voxels wide (diameter_mm = 0.5, voxels of 0.2 mm): below 3 voxels "
                                   "it removes up to 40 % too little bone; use voxels of at most 0.166 mm"));
  EXPECT_THAT(FindVoxelWarnings(params, 0.5),
              testing::ElementsAre(testing::HasSubstr("below 1.5 voxels it removes only a part of the bone or none")));
  EXPECT_THAT(FindVoxelWarnings(params, 0), testing::IsEmpty()) << "unknown";
  params.tool = BallBurr{.diameter_mm = 6};
  EXPECT_THAT(FindVoxelWarnings(params, 2), testing::IsEmpty());
  EXPECT_THAT(FindVoxelWarnings(params, 2.1), testing::ElementsAre(testing::HasSubstr("the ball is 2.86 voxels wide")));
  params.tool = FissureBur{.diameter_mm = 1.6};
  EXPECT_THAT(FindVoxelWarnings(params, 1), testing::ElementsAre(testing::HasSubstr("the bur is 1.6 voxels wide")));
}

/// Returns the warnings about strokes that each continue the one before, of a tool with its axis along z.
std::vector<std::string> WarningsOfStrokes(const Tool& tool, const std::vector<Vec3>& places) {
  Scene scene;
  scene.tool.shape = tool;
  for (std::size_t i = 1; i < places.size(); ++i) {
    scene.path.strokes.push_back(
        {.start_mm = places[i - 1], .end_mm = places[i], .disc_normal = {0, 0, 2}, .retract = i == 1});
  }
  std::vector<std::string> warnings;
  for (const std::string& warning : FindWarnings(scene, 0.1)) {
    if (warning.starts_with("stroke")) warnings.push_back(warning);
  }
  return warnings;
}

TEST(Doubts, DrillThatTurnsBackwardsIsNamed) {
  Scene scene;
  const auto backwards = testing::Contains(testing::HasSubstr("a drill that turns backwards does not cut"));
  scene.tool.shape = TwistDrill{};
  EXPECT_THAT(FindWarnings(scene, 0.1), testing::Not(backwards));
  scene.tool.reverse = true;
  EXPECT_THAT(FindWarnings(scene, 0.1), backwards);
  scene.tool.shape = DiscSaw{};
  EXPECT_THAT(FindWarnings(scene, 0.1), testing::Not(backwards));
}

TEST(Doubts, ToolThatGoesTopFirstIsNamed) {
  const auto top_first = testing::ElementsAre(
      testing::MatchesRegex("stroke 1 moves the (drill|bur) with its top first: it removes bone, but without a force; "
                            "disc_normal must point from its tip to the handpiece: reverse it"));
  for (const Tool& tool : {Tool(TwistDrill{}), Tool(FissureBur{})}) {
    EXPECT_THAT(WarningsOfStrokes(tool, {{0, 0, 0}, {0, 0, 4}}), top_first);
    EXPECT_THAT(WarningsOfStrokes(tool, {{0, 0, 0}, {0, 0, 4}, {0, 0, 0}}), top_first) << "in and out";
    EXPECT_THAT(WarningsOfStrokes(tool, {{0, 0, 4}, {0, 0, 0}, {0, 0, 9}}), testing::IsEmpty()) << "withdrawn";
    EXPECT_THAT(WarningsOfStrokes(tool, {{0, 0, 4}, {0, 0, 5}, {0, 0, 0}}), testing::IsEmpty()) << "raised before";
  }
  EXPECT_THAT(WarningsOfStrokes(FissureBur{}, {{0, 0, 0}, {9, 0, 1}}), testing::IsEmpty()) << "sideways";
  EXPECT_THAT(WarningsOfStrokes(BallBurr{}, {{0, 0, 0}, {0, 0, 4}}), testing::IsEmpty());
}

// Each warning about a path file is given once, for the first place, if most of the path is so.
TEST(Doubts, PathFileIsCheckedAsStrokesAre) {
  Scene scene;
  const auto set_path = [&](const std::vector<Vec3>& places) {
    scene.path.poses.clear();
    for (std::size_t i = 0; i < places.size(); ++i) {
      scene.path.poses.push_back({10 + 0.5 * static_cast<double>(i), {Quat(1, 0, 0, 0), places[i]}});
    }
  };
  set_path({{0, 0, 0}, {2, 0, 0.001}, {2.05, 0, 0.04}, {4, 0, 0}, {6, 0, 2}, {8, 0, 6}});
  const auto find = [&] {
    std::vector<std::string> warnings;
    for (const std::string& warning : FindWarnings(scene, 0.1)) {
      if (warning.starts_with("the path")) warnings.push_back(warning);
    }
    return warnings;
  };
  EXPECT_THAT(find(), testing::ElementsAre("the path file, from time_s = 11.5 on, moves 45 degrees out of the disc's "
                                           "plane: the flats remove bone, but only the teeth exert a force"));
  set_path({{0, 0, 0}, {8, 0, 0}, {8, 0, 6}});
  EXPECT_THAT(find(), testing::IsEmpty()) << "moved aside at the end";
  scene.tool.shape = TwistDrill{};
  EXPECT_THAT(find(), testing::ElementsAre(testing::StartsWith(
                          "the path file, from time_s = 10 on, moves 90 degrees away from the drill's axis")));
  set_path({{0, 0, 0}, {0, 0, 4}, {0, 0, -1}});
  EXPECT_THAT(find(), testing::ElementsAre(testing::HasSubstr("time_s = 10 on, moves the drill with its top first")));
  set_path({{0, 0, 0}, {0, 0, -6}, {0, 0, 4}});
  EXPECT_THAT(find(), testing::IsEmpty());
}

TEST(Doubts, TurnByWhichFacesWithoutTeethCutIsNamed) {
  Scene scene;
  const auto find = [&](const Tool& tool, const Vec3& about) {
    scene.tool.shape = tool;
    scene.path.poses = {{0, {Quat(1, 0, 0, 0), Vec3(0)}}, {1, {glm::angleAxis(0.5235987756, about), Vec3(0)}}};
    std::vector<std::string> found;
    for (const std::string& warning : FindWarnings(scene, 0.1)) {
      if (warning.starts_with("the path file turns")) found.push_back(warning);
    }
    return found;
  };
  const Vec3 across(1, 0, 0), axis(0, 0, 1);
  EXPECT_THAT(find(TwistDrill{}, across),
              testing::ElementsAre(testing::HasSubstr("turns the tool by up to 30 degrees away from its axis")));
  EXPECT_THAT(find(OscillatingBlade{}, across),
              testing::ElementsAre(testing::HasSubstr("30 degrees out of its plane")));
  EXPECT_THAT(find(TwistDrill{}, axis), testing::IsEmpty());
  EXPECT_THAT(find(OscillatingBlade{}, axis), testing::IsEmpty()) << "its teeth move";
  EXPECT_THAT(find(FissureBur{}, across), testing::IsEmpty()) << "its side has teeth";
  EXPECT_THAT(find(DiscSaw{}, across), testing::IsEmpty());
}

TEST(Doubts, WantedCutDeeperThanTheToolIsNamed) {
  Scene scene;
  scene.exercise.given = true;
  scene.exercise.kind = ExerciseKind::kDrillHoles;
  scene.exercise.depth_mm = 3;
  scene.exercise.further.push_back({.depth_mm = 6});
  const auto find = [&](const Tool& tool) {
    scene.tool.shape = tool;
    std::vector<std::string> warnings;
    for (const std::string& warning : FindWarnings(scene, 0.1)) {
      if (warning.find(" mm deep, but only ") != std::string::npos) warnings.push_back(warning);
    }
    return warnings;
  };
  EXPECT_THAT(find(TwistDrill{.length_mm = 6}), testing::IsEmpty());
  EXPECT_THAT(find(TwistDrill{.length_mm = 3}),
              testing::ElementsAre("the hole is 6 mm deep, but only 3 mm of the drill are modelled above its tip"));
  scene.exercise.kind = ExerciseKind::kGroove;
  EXPECT_THAT(find(FissureBur{.length_mm = 2}), testing::ElementsAre(testing::StartsWith("the wanted cut is 6 mm")));
  EXPECT_THAT(find(PiezoInsert{.length_mm = 5}), testing::ElementsAre(testing::HasSubstr("only 5 mm of the blade")));
  EXPECT_THAT(find(OscillatingBlade{}), testing::IsEmpty());
  EXPECT_THAT(find(ReciprocatingBlade{.width_mm = 2}), testing::IsEmpty());
  EXPECT_THAT(find(DiscSaw{.diameter_mm = 8}), testing::IsEmpty());
}

TEST(Doubts, StoppedSpindleHasNoSign) {
  const Scene scene = ParseScene(test::ShortScene() + "[tool]\nrpm = -0.0\n", "s.toml");
  EXPECT_FALSE(std::signbit(scene.tool.rpm));
}

TEST(Doubts, EveryLawWarnsJustOutsideItsRangeAndNotInside) {
  for (const ForceLawInfo* law : ForceLaws()) {
    if (IsNowhereMeasured(law->validity)) continue;
    const double from_um = 1000 * law->validity.from_mm;
    const double to_um = std::min(1000 * law->validity.to_mm, 300.0);
    EXPECT_EQ(WarningsAt(std::max(from_um * 1.01, 0.01), law->name), "") << law->name;
    EXPECT_EQ(WarningsAt(to_um * 0.99, law->name), "") << law->name;
    if (*law->validity.below != '\0') {
      EXPECT_NE(WarningsAt(from_um * 0.99, law->name), "") << law->name;
    }
    if (to_um < 300) {
      EXPECT_NE(WarningsAt(to_um * 1.01, law->name), "") << law->name;
    }
  }
}

}  // namespace
}  // namespace kerf
