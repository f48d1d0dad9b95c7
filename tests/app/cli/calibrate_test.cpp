// Tests of kerf calibrate as a user runs it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "support/program.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

// Thrust (9 + 500 h) N/mm and cutting force (6 + 200 h) N/mm on a tooth 0.5 mm wide, each with an error of 0.01 N.
constexpr const char* kForces =
    "bite_mm,width_mm,thrust_N,cutting_N\n"
    "0.003,0.5,5.26,3.29\n0.003,0.5,5.24,3.31\n0.006,0.5,6.01,3.61\n0.006,0.5,5.99,3.59\n"
    "0.009,0.5,6.74,3.89\n0.009,0.5,6.76,3.91\n";

class Calibrate : public test::ProgramTest {
 protected:
  Calibrate() : ProgramTest({{"forces.csv", kForces}}) {}
};

TEST_F(Calibrate, PrintsTablesAndTheLawBlock) {
  const auto result = Kerf("calibrate forces.csv --bootstrap 200");
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("two_component fitted to forces.csv: 12 values, bites of 3 to 9 um\n"));
  EXPECT_THAT(result.out, HasSubstr("[force]\nlaw = \"two_component\"\nthrust_edge_N_per_mm = 9 "));
  EXPECT_THAT(result.out, HasSubstr("cutting_chip_N_per_mm2 = 200 "));
  EXPECT_THAT(result.err, HasSubstr("kerf: warning: crossover_share is not determined"));
}

TEST_F(Calibrate, WritesReportFigureLawAndJson) {
  const auto result = Kerf("calibrate '" + (folder_ / "forces.csv").string() + "' -o out --bootstrap 200 --json");
  EXPECT_EQ(result.code, 0) << result.err;
  for (const char* file : {"report.md", "fit.png", "law.toml", "calibrate.json"}) {
    EXPECT_TRUE(Exists(std::string("out/") + file)) << file;
    // The files contain no path of this machine.
    EXPECT_EQ(test::Slurp(folder_ / "out" / file).find(folder_.string()), std::string::npos) << file;
  }
  EXPECT_EQ(result.out, test::Slurp(folder_ / "out/calibrate.json"));
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json["law_block"], test::Slurp(folder_ / "out/law.toml"));
  EXPECT_EQ(json["parameters"][0]["key"], "thrust_edge_N_per_mm");
  EXPECT_NEAR(json["parameters"][0]["value"].get<double>(), 9, 1e-9);
  for (const std::string warning : json["warnings"]) {
    EXPECT_THAT(result.err, HasSubstr("kerf: warning: " + warning + "\n"));
    EXPECT_THAT(test::Slurp(folder_ / "out/report.md"), HasSubstr("- " + warning + "\n"));
  }
}

TEST_F(Calibrate, BadUsageIsRefusedInOneSentence) {
  for (const auto& [arguments, message] : std::vector<std::pair<std::string, std::string>>{
           {"forces.csv --law hertz", "--law: "},
           {"forces.csv --set crossover_share", "--set: 'crossover_share' must be key=value"},
           {"forces.csv --set crossover_shar=0.3", "did you mean \"crossover_share\"?"},
           {"forces.csv --set crossover_share=-1", "crossover_share = -1 is below 0"},
           {"forces.csv --bootstrap 99", "valid range 100 to 100000, or 0"},
           {"forces.csv --bootstrap -1", "--bootstrap: -1 is below 100"},
           {"", "DATA"}}) {
    const auto result = Kerf("calibrate " + arguments);
    EXPECT_EQ(result.code, 2) << arguments;
    EXPECT_EQ(result.out, "");
    EXPECT_THAT(result.err, HasSubstr(message));
  }
}

TEST_F(Calibrate, BadDataAreRefusedWithTheirPlaceAndNothingIsWritten) {
  Write("bad.csv", "bite_mm,width_mm,thrust_N\n0.003,0.5,5\n0.004,0.5,-5\n");
  auto result = Kerf("calibrate bad.csv -o out");
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "kerf: bad.csv:3: thrust_N = -5 is below 0; valid range 0 to 100000 N\n");
  Write("one.csv", "bite_mm,width_mm,thrust_N\n0.003,0.5,5\n0.003,0.5,6\n");
  result = Kerf("calibrate one.csv -o out");
  EXPECT_EQ(result.code, 1);
  EXPECT_EQ(result.err, "kerf: one.csv: the data determine no coefficient of two_component: all bites are 0.003 mm\n");
  EXPECT_EQ(Kerf("calibrate missing.csv -o out").code, 1);
  EXPECT_FALSE(Exists("out"));
  Write("report.md", kForces);
  EXPECT_EQ(Kerf("calibrate report.md -o .").code, 1);
  EXPECT_EQ(test::Slurp(folder_ / "report.md"), kForces);
}

}  // namespace
}  // namespace kerf
