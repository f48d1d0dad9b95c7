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

}  // namespace
}  // namespace kerf
