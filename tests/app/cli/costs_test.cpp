// Tests of kerf run --costs and kerf loop --costs, run as programs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/block_scene.h"
#include "support/program.h"

namespace kerf {
namespace {

using Json = nlohmann::json;
using test::ProgramResult;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kCostsScene =
    test::BlockToml({6, 4, 3}, 0.25) + test::SawToml(12, 0.5, 16) +
    "[effects.tangential_force]\n[output]\nbone = false\npictures = false\npieces = false\n" +
    test::StrokeToml({0, 0, 6.5}, {0, 0, 5}, 6, {1, 0, 0});

class Costs : public test::ProgramTest {
 protected:
  Costs() : ProgramTest({{"s.toml", kCostsScene}}) {}
};

/// Every stage and effect has times, and the sum of the stages' means does not exceed the tick's mean.
void CheckParts(const Json& costs) {
  EXPECT_EQ(costs.at("budget_us"), 1000);
  double sum_us = 0;
  ASSERT_FALSE(costs.at("stages").empty());
  for (const auto& [name, stage] : costs.at("stages").items()) sum_us += stage.at("mean_us").get<double>();
  EXPECT_LE(sum_us, costs.at("tick").at("mean_us").get<double>() * 1.001);
  EXPECT_EQ(costs.at("effects").size(), 1u);
  EXPECT_TRUE(costs.at("effects").contains("tangential_force"));
}

TEST_F(Costs, RunReportsThemAsTableAndJson) {
  const ProgramResult table = Kerf("run s.toml -o out --costs");
  ASSERT_EQ(table.code, 0) << table.err;
  for (const char* part : {"engage", "remove", "p99 of budget"}) EXPECT_THAT(table.out, HasSubstr(part));
  EXPECT_THAT(Kerf("run s.toml -o out").out, Not(HasSubstr("p99 of budget")));
  const ProgramResult json = Kerf("run s.toml -o out --costs --json");
  ASSERT_EQ(json.code, 0) << json.err;
  CheckParts(Json::parse(json.out).at("costs"));
  EXPECT_FALSE(Json::parse(Kerf("run s.toml -o out --json").out).contains("costs"));
}

TEST_F(Costs, LoopReportsThemAsTableAndJson) {
  // In real time: on a stalled machine the tool may not have reached the bone yet, so longer runs are tried.
  ProgramResult table;
  for (const char* seconds : {"0.5", "3", "10", "30"}) {
    table = Kerf(std::string("loop s.toml --costs --seconds ") + seconds);
    ASSERT_EQ(table.code, 0) << table.err;
    if (table.out.find("remove") != std::string::npos) break;
  }
  for (const char* part : {"engage", "remove", "p99 of budget"}) EXPECT_THAT(table.out, HasSubstr(part));
  const ProgramResult json = Kerf("loop s.toml --seconds 0.3 --costs --json");
  ASSERT_EQ(json.code, 0) << json.err;
  CheckParts(Json::parse(json.out).at("costs"));
}

TEST_F(Costs, AreNotAvailableInVirtualTime) {
  const ProgramResult result = Kerf("loop s.toml --seconds 0.3 --costs --virtual");
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--virtual"));
}

}  // namespace
}  // namespace kerf
