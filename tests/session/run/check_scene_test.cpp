// Tests of the errors and messages of `kerf check` before a bone is constructed.
#include "session/run/check_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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
      make("shape = \"reciprocating\"\nlength_mm = 20\nwidth_mm = 6\nthickness_mm = 0.4\nE_MPa = 200000\n");
  EXPECT_THAT(blade, HasSubstr("2.4 N/mm, its bending"));
  EXPECT_THAT(of_blade, Not(Contains(HasSubstr("blade_bends"))));
  const auto [drill, of_drill] = make("shape = \"drill\"\n");
  EXPECT_THAT(drill, Not(HasSubstr("bending")));
  EXPECT_THAT(of_drill, Contains(HasSubstr("blade_bends")));
}

}  // namespace
}  // namespace kerf
