// Tests of the errors and messages of `kerf check` before a bone is constructed.
#include "session/run/check_scene.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "bone/models/block.h"
#include "session/run/loop_setup.h"
#include "session/run/make_bone.h"
#include "support/block_scene.h"
#include "support/folder.h"

namespace kerf {
namespace {

using test::MakeBlockScene;
using test::MessageOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

std::string WithLayers(const std::string& layers) {
  std::string scene = MakeBlockScene();
  return scene.insert(scene.find("[tool]"), layers);
}

// The block is 3 mm high.
TEST(CheckScene, RefusesTheSameLayersAsMakingTheBlock) {
  const std::string first = "[[bone.block.layer]]\nthickness_mm = {}\nregion = 24\n";
  const std::string second = "[[bone.block.layer]]\nthickness_mm = 1\nregion = {}\n";
  for (const auto& [thickness_mm, region] : {std::pair(250.0, 32), {3.0, 32}, {2.9, 99}, {2.9, 32}}) {
    const Scene scene = ParseScene(
        WithLayers(fmt::format(fmt::runtime(first), thickness_mm) + fmt::format(fmt::runtime(second), region)),
        "s.toml");
    const std::string made = MessageOf([&] { MakeSceneBone(scene, {}); });
    EXPECT_EQ(MessageOf([&] { CheckWholeScene(scene); }), made) << thickness_mm << " " << region;
    EXPECT_EQ(made.empty(), thickness_mm < 3 && region == 32) << made;
  }
}

TEST(CheckScene, DescribesABlockWithAndWithoutLayers) {
  EXPECT_THAT(CheckWholeScene(ParseScene(MakeBlockScene(), "s.toml")).bone, HasSubstr("3 mm, one region, voxels"));
  const std::string layer = WithLayers("[[bone.block.layer]]\nthickness_mm = 3\nregion = 24\n");
  EXPECT_THAT(CheckWholeScene(ParseScene(layer, "s.toml")).bone, HasSubstr("3 mm, 1 layer, voxels"));
}

// The block is 6 x 4 x 3 mm, with its top at z = 0.
TEST(CheckScene, RefusesAnExerciseBesideItsBone) {
  const auto check = [](const std::string& start, const std::string& end, const char* bone = "") {
    std::string scene = MakeBlockScene({}, "[exercise]\nkind = \"osteotomy\"\ndepth_mm = 1\nstart_mm = [" + start +
                                               "]\nend_mm = [" + end + "]\ninto = [0, 0, -1]\n");
    if (*bone != 0) scene = std::string(bone) + scene.substr(scene.find("[tool]"));
    return MessageOf([&] { CheckWholeScene(ParseScene(scene, "s.toml")); });
  };
  const auto fault = testing::MatchesRegex(
      "s.toml:[0-9]+:1: the wanted cut lies beside the bone: no point of it, from the line between start_mm and end_mm "
      "along into to depth_mm, is in bone");
  EXPECT_EQ(check("-2, 0, 0", "2, 0, 0"), "");
  EXPECT_EQ(check("-9, 0, 0", "-2.5, 0, 0"), "") << "its end is on the bone";
  EXPECT_EQ(check("-2, 0, 0.9", "2, 0, 0.9"), "") << "its floor is in the bone";
  EXPECT_THAT(check("-2, 0, 1.2", "2, 0, 1.2"), fault) << "above it";
  EXPECT_THAT(check("-2, 2.2, 0", "2, 2.2, 0"), fault) << "beside it";
  EXPECT_THAT(check("-9, 0, 0", "-3.2, 0, 0"), fault) << "in front of it";
  const char* const mandible = "[bone]\nmodel = \"mandible\"\n";
  EXPECT_EQ(check("-4, 8, -25", "4, 8, -25", mandible), "") << "in the chin";
  EXPECT_THAT(check("-4, 30, -25", "4, 30, -25", mandible), fault) << "behind it";
}

TEST(CheckScene, NamesTheHoleThatLiesBesideTheBone) {
  std::string scene = MakeBlockScene({},
                                     "[exercise]\nkind = \"drill_holes\"\nstart_mm = [0, 0, 0]\n"
                                     "[[exercise.cut]]\nstart_mm = [0, 3, 0]\ninto = [0, 0, -1]\n");
  scene.replace(scene.find("[tool]"), scene.find("[[path") - scene.find("[tool]"), "[tool]\nshape = \"drill\"\n");
  const auto lines = std::count(scene.begin(), scene.end(), '\n');
  EXPECT_EQ(
      MessageOf([&] { CheckWholeScene(ParseScene(scene, "s.toml")); }),
      fmt::format("s.toml:{}:1: the hole lies beside the bone: no point of it, from start_mm along into to depth_mm, "
                  "is in bone",
                  lines - 1));
}

// The block is 6 x 4 x 3 mm, with its top at z = 0.
TEST(CheckScene, WarnsOfACutThatBeginsInsideBoneOrLeavesIt) {
  const auto check = [](const std::string& exercise) {
    std::string scene = MakeBlockScene({}, "[exercise]\ndepth_mm = 0.9\n" + exercise);
    if (exercise.find("end_mm") == std::string::npos) {
      scene.replace(scene.find("[tool]"), scene.find("[[path") - scene.find("[tool]"), "[tool]\nshape = \"drill\"\n");
    }
    std::vector<std::string> warnings;
    for (const std::string& warning : CheckWholeScene(ParseScene(scene, "s.toml")).warnings) {
      if (warning.starts_with("wanted cut 1: ") || warning.starts_with("hole 1: "))
        warnings.push_back(warning.substr(warning.find(": ") + 2));
    }
    return warnings;
  };
  const auto cut = [&](const std::string& z_mm, const char* into) {
    return check("start_mm = [-2, 0, " + z_mm + "]\nend_mm = [2, 0, " + z_mm + "]\ninto = [0, 0, " + into + "]\n");
  };
  const auto hole = [&](const char* z_mm, const char* into) {
    return check(fmt::format("kind = \"drill_holes\"\nstart_mm = [0, 0, {}]\ninto = [0, 0, {}]\n", z_mm, into));
  };
  EXPECT_THAT(cut("0", "-1"), testing::IsEmpty());
  EXPECT_THAT(cut("-1.5", "-1"), testing::IsEmpty());
  EXPECT_THAT(cut("-2.2", "-1"), testing::ElementsAre("bone rises up to 2.2 mm above the line between start_mm and "
                                                      "end_mm, which are to be on the surface: the tool begins inside "
                                                      "the bone"));
  EXPECT_THAT(cut("0", "1"), testing::ElementsAre(testing::StartsWith("only 0 % of it is in bone; into must point")));
  EXPECT_THAT(hole("0", "-1"), testing::IsEmpty());
  EXPECT_THAT(hole("-2.2", "-1"), testing::ElementsAre(testing::StartsWith("bone rises up to 2.2 mm above start_mm")));
  EXPECT_THAT(hole("0", "1"), testing::ElementsAre(testing::StartsWith("only 0 % of it is in bone")));
}

TEST(CheckScene, MissingBoneOfASessionIsWrittenByAReplay) {
  std::string scene = MakeBlockScene();
  scene = "[bone]\nfile = \"none/bone.vdb\"\n" + scene.substr(scene.find("[tool]"));
  EXPECT_THAT(MessageOf([&] { CheckWholeScene(ParseScene(scene, "/s/s.toml")); }),
              testing::StartsWith("/s/none/bone.vdb: there is no such file; 'kerf replay RECORDING -o /s/none' writes "
                                  "it if it is the bone that a recorded session left, and 'kerf import INPUT -o "));
}

TEST(DescribeCoupling, NamesOnlyLoweredValues) {
  const auto describe = [](const std::string& coupling) {
    return DescribeCoupling(MakeLoopSetup(ParseScene(MakeBlockScene({}, "[coupling]\n" + coupling), "s.toml")));
  };
  EXPECT_THAT(describe("stiffness_N_per_mm = 1\n"), Not(HasSubstr("lowered")));
  EXPECT_THAT(describe("stiffness_N_per_mm = 1000\n"), HasSubstr(", lowered from 1000 to "));
  const std::string damped = describe("stiffness_N_per_mm = 1\ndamping_Ns_per_mm = 0.2\n");
  EXPECT_THAT(damped, HasSubstr("; its damping lowered from 0.2 to "));
  EXPECT_THAT(damped, Not(HasSubstr(", lowered")));
}

TEST(DescribeCoupling, StatesTheBendingOfABlade) {
  const auto make = [](const std::string& tool) {
    const Scene scene =
        ParseScene(test::BlockToml({6, 4, 3}, 0.25) + "[tool]\n" + tool +
                       test::StrokeToml({0, 0, 4}, {0, 0, 1}, 3, {0, 1, 0}) + "[coupling]\nblade_bends = true\n",
                   "s.toml");
    const LoopSetup setup = MakeLoopSetup(scene);
    return std::pair(DescribeCoupling(setup), FindHandWarnings(scene, setup));
  };
  // 3 E I / L^3 = E b t^3 / (4 L^3), with a Young's modulus of 200 GPa.
  const auto [blade, of_blade] =
      make("shape = \"reciprocating\"\nlength_mm = 20\nwidth_mm = 6\nthickness_mm = 0.4\nE_GPa = 200.0\n");
  EXPECT_THAT(blade, HasSubstr("2.4 N/mm, its bending"));
  EXPECT_THAT(of_blade, Not(Contains(HasSubstr("blade_bends"))));
  const auto [drill, of_drill] = make("shape = \"drill\"\n");
  EXPECT_THAT(drill, Not(HasSubstr("bending")));
  EXPECT_THAT(of_drill, Contains(HasSubstr("blade_bends")));
}

}  // namespace
}  // namespace kerf
