// Tests of kerf effects as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

const std::string kEffectsScene = test::BlockToml({6, 4, 3}, 0.25) + test::SawToml(12, 0.5, 16) +
                                  test::StrokeToml({0, 0, 7.6}, {0, 0, 4.5}, 6, {1, 0, 0});
constexpr char kFriction[] = "[effects.kerf_friction]\ncoefficient = 0.3\n";

class EffectsCommand : public test::ProgramTest {
 protected:
  EffectsCommand() : ProgramTest({{"plain.toml", kEffectsScene}, {"rubs.toml", kEffectsScene + kFriction}}) {}
  Json Measure(const std::string& arguments) const {
    const auto result = Kerf("effects " + arguments + " --seconds 0.1 --passes 2 --json");
    EXPECT_EQ(result.code, 0) << result.err;
    return Json::parse(result.out, nullptr, false);
  }
};

TEST_F(EffectsCommand, ListsAllWithTheirParameters) {
  const auto text = Kerf("effects");
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("\nkerf_friction\n"));
  EXPECT_THAT(text.out, HasSubstr("coefficient"));
  const auto json = Json::parse(Kerf("effects --json").out);
  ASSERT_GE(json["effects"].size(), 1u);
  EXPECT_EQ(json["effects"][0]["name"], "kerf_friction");
  EXPECT_EQ(json["effects"][0]["needs_hand"], true);
  EXPECT_EQ(json["effects"][0]["parameters"][0]["default"], 0.2);
  EXPECT_EQ(json["effects"][0]["parameters"][0]["range"][1], 2.0);
  for (const Json& effect : json["effects"]) EXPECT_TRUE(effect.contains("cost"));
}

TEST_F(EffectsCommand, ListsEnabledEffectsOfASceneAndTheirCosts) {
  const Json json = Measure("rubs.toml");
  ASSERT_EQ(json["on"].size(), 1u);
  const Json& friction = json["on"][0];
  EXPECT_EQ(friction["name"], "kerf_friction");
  EXPECT_EQ(friction["why"], "the scene names it");
  EXPECT_EQ(friction["with_it"]["cutting"]["ticks"], 100);
  EXPECT_GT(friction["with_it"]["cutting"]["p99_us"], 0);
  EXPECT_GE(friction["with_it"]["cutting"]["p99_us"], friction["with_it"]["cutting"]["p50_us"]);
  EXPECT_GT(friction["memory_MB"], 0);
  EXPECT_EQ(json["together"]["with_it"]["force_hash"], friction["with_it"]["force_hash"]);
  EXPECT_NEAR(json["fits_kHz"].get<double>() * json["together"]["with_it"]["cutting"]["p99_us"].get<double>(), 1000, 1);
  for (const Json& left_out : json["left_out"]) EXPECT_EQ(left_out["why"], "the scene does not name it");
  EXPECT_GT(json["mean_engaged_teeth"], 0);
}

TEST_F(EffectsCommand, EffectsThatTheSceneDoesNotNameAreOff) {
  const Json json = Measure("plain.toml");
  EXPECT_TRUE(json["on"].empty());
  EXPECT_EQ(json["together"]["only_observes"], true);
  EXPECT_EQ(json["together"]["memory_MB"], 0);
  EXPECT_EQ(json["left_out"].size(), Json::parse(Kerf("effects --json").out)["effects"].size());
}

TEST_F(EffectsCommand, EffectsThatNeedAHandAreLeftOutWithoutOne) {
  const Json json = Measure("rubs.toml --run");
  EXPECT_TRUE(json["on"].empty());
  EXPECT_EQ(json["left_out"][0]["name"], "kerf_friction");
  EXPECT_THAT(json["left_out"][0]["why"].get<std::string>(), HasSubstr("needs a tool coupled to a handle"));
}

TEST_F(EffectsCommand, WritesTheDisplayedTable) {
  const auto result = Kerf("effects plain.toml --all --seconds 0.1 --passes 1 --voxel 0.3 --markdown --csv costs.csv");
  ASSERT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("| kerf_friction |"));
  EXPECT_THAT(result.out, HasSubstr("0.3 mm voxels"));
  EXPECT_THAT(test::Slurp(folder_ / "costs.csv"), HasSubstr("\nkerf_friction,"));
}

// A run along a path continues while the spindle is stalled, without cutting; a message reports it.
TEST_F(EffectsCommand, RunReportsAStalledSpindle) {
  const std::string scene = kEffectsScene +
                            "[output]\npictures = false\n[effects.tangential_force]\n[effects.spindle]\n"
                            "friction_Nmm = 0.1\nviscous_Nmms = 0\n";
  Write("strong.toml", scene + "stall_torque_Nmm = 1e5\n");
  Write("weak.toml", scene + "stall_torque_Nmm = 1\n");
  EXPECT_THAT(Kerf("run strong.toml -o strong").err, Not(HasSubstr("stalled")));
  const auto weak = Kerf("run weak.toml -o weak");
  EXPECT_EQ(weak.code, 0);
  EXPECT_THAT(weak.err, HasSubstr("the spindle stalled, and the tool continued along its path without cutting"));
}

TEST_F(EffectsCommand, RunReportsHowFarThePathExceedsTheGuide) {
  const std::string scene = kEffectsScene +
                            "[output]\npictures = false\n[effects.guide]\nnormal = [1, 0, 0]\n"
                            "depth_direction = [0, 0, -1]\n";
  // The rim's lowest point ends 1.5 mm below the lowest point of the guide.
  Write("deep.toml", scene + "depth_mm = 1\n");
  Write("fair.toml", scene + "depth_mm = 2\n");
  EXPECT_THAT(Kerf("run deep.toml -o deep").err, HasSubstr("the path goes 0.5 mm past the depth stop of the guide"));
  EXPECT_THAT(Kerf("run fair.toml -o fair").err, Not(HasSubstr("guide")));
}

TEST_F(EffectsCommand, CheckDetectsInconsistentParameters) {
  Write("none.toml", kEffectsScene + "[effects.guide]\nnormal = [0, 0, 0]\n");
  Write("out.toml", kEffectsScene + "[effects.guide]\nnormal = [0, 0, 1]\n");
  Write("rate.toml", kEffectsScene + "[effects.sound]\nrate_Hz = 44100.5\n");
  EXPECT_THAT(Kerf("check none.toml").err, HasSubstr("[effects.guide]: normal has no direction: its length is 0"));
  EXPECT_THAT(Kerf("check out.toml").err, HasSubstr("depth_direction does not lie in the plane"));
  EXPECT_THAT(Kerf("check rate.toml").err,
              ContainsRegex("rate.toml:[0-9]+:[0-9]+: rate_Hz = 44100.5 is not a whole number"));
}

TEST_F(EffectsCommand, ListsOneEffectByItsName) {
  const auto one = Kerf("effects heat");
  EXPECT_EQ(one.code, 0);
  EXPECT_EQ(one.out.substr(0, 6), "\nheat\n");
  EXPECT_THAT(one.out, Not(HasSubstr("\nguide\n")));
}

TEST_F(EffectsCommand, NoCostIsShownBelowZero) {
  const auto list = Kerf("effects");
  EXPECT_THAT(list.out, HasSubstr("below the noise"));
  for (std::size_t at = list.out.find("  cost "); at != std::string::npos; at = list.out.find("  cost ", at + 1)) {
    const std::string line = list.out.substr(at, list.out.find('\n', at) - at);
    EXPECT_EQ(line.find('-'), std::string::npos) << line;
  }
}

TEST_F(EffectsCommand, ListsOneEffectAsJson) {
  const auto one = Kerf("effects heat --json");
  ASSERT_EQ(one.code, 0) << one.err;
  const Json json = Json::parse(one.out, nullptr, false);
  ASSERT_EQ(json["effects"].size(), 1u);
  EXPECT_EQ(json["effects"][0]["name"], "heat");
  const Json all = Json::parse(Kerf("effects --json").out);
  EXPECT_THAT(all["effects"], testing::Contains(json["effects"][0]));
}

TEST_F(EffectsCommand, UnknownNameSuggestsTheNearest) {
  for (const char* json : {"", " --json"}) {
    ExpectRefusal(Kerf(std::string("effects haet") + json),
                  "\"haet\" is neither an effect nor a scene file; the nearest effect is \"heat\"");
  }
  EXPECT_THAT(Kerf("effects quux").err, HasSubstr("the effects are kerf_friction, "));
  ExpectRefusal(Kerf("effects haet.toml"), "haet.toml: there is no such file");
}

TEST_F(EffectsCommand, RefusesBadUsageAndPathsWithoutContact) {
  EXPECT_EQ(Kerf("effects --all").code, 2);
  EXPECT_EQ(Kerf("effects plain.toml --seconds 0").code, 2);
  EXPECT_EQ(Kerf("effects plain.toml --realtime").code, 2);
  ExpectRefusal(Kerf("effects plain.toml --csv plain.toml"),
                "plain.toml: is an input and would be overwritten by plain.toml; choose another output");
  std::string away = kEffectsScene;
  away.replace(away.find("end_mm = [0.0, 0.0, 4.5]"), 24, "end_mm = [0.0, 0.0, 7.4]");
  Write("away.toml", away);
  const auto result = Kerf("effects away.toml --run");
  EXPECT_EQ(result.code, 1);
  EXPECT_THAT(result.err, HasSubstr("the tool touches no bone"));
}

}  // namespace
}  // namespace kerf
