// Tests what kerf check and a run's summary report about a force law besides its forces.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "cut/force/measured.h"
#include "support/block_scene.h"
#include "support/forces_csv.h"
#include "support/program.h"

namespace kerf {
namespace {

using test::ProgramResult;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

/// Returns a scene with a kerf 2 mm deep through a block, with a bite of 1 um for every 3 mm/s of feed.
std::string Slot(double feed_mm_per_s, const std::string& law) {
  return test::BlockToml({4, 2, 4}, 0.1) + test::StrokeToml({-9, 0, 9}, {9, 0, 9}, feed_mm_per_s, {0, 1, 0}) +
         "[force]\nlaw = \"" + law + "\"\n[output]\npictures = false\nbone = false\npieces = false\n";
}

class Law : public test::ProgramTest {};

TEST_F(Law, CheckStatesTheLawsRangeAndWarnsOutside) {
  for (const ForceLawInfo* law : ForceLaws()) {
    Write("s.toml", Slot(6, law->name));
    const ProgramResult text = Kerf("check s.toml");
    EXPECT_EQ(text.code, 0) << text.err;
    const ForceLaw by_default(law->name);
    EXPECT_THAT(text.out, HasSubstr(DescribeAccuracy(by_default, DiscSaw{})));
    EXPECT_THAT(text.out, HasSubstr(DescribeBlades(by_default, DiscSaw{})));
    EXPECT_THAT(text.out, HasSubstr(FindCaveat(*law).good_for));
    EXPECT_THAT(text.out, HasSubstr("J/mm3 (derived from published forces at bites of 2.5 um and more: 0.83 "
                                    "to 2.9, with the upper bound doubled)"));
    const Json json = Json::parse(Kerf("check s.toml --json").out);
    EXPECT_EQ(json["force"]["accuracy"], DescribeAccuracy(by_default, DiscSaw{}));
    EXPECT_EQ(json["force"]["blades"], DescribeBlades(by_default, DiscSaw{}));
    EXPECT_EQ(json["force"]["good_for"], FindCaveat(*law).good_for);
    EXPECT_EQ(json["force"]["from_measured_forces_J_per_mm3"], Json({0.83, 2.9}));
    EXPECT_EQ(json["force"]["widened_J_per_mm3"], Json({0.8, 6.0}));
  }
  // The bite is 10 um. Calculated by hand: 84.6 N and, with the factor 1.6, 0.25 mm and 10 um, 21.2 J/mm3.
  Write("s.toml", Slot(30, "hertz_chip"));
  const ProgramResult deep = Kerf("check s.toml");
  EXPECT_THAT(
      deep.out,
      HasSubstr(
          "at that bite 84.6 N of thrust and 52.9 N of cutting force on a tooth in cortical bone, "
          "21.2 J/mm3; outside 0.8 to 6 J/mm3 (derived from published forces at bites of 2.5 um and more: 0.83 to "
          "2.9, with the upper bound doubled)\n"));
  EXPECT_THAT(deep.err, HasSubstr("warning: the bite reaches 10 um: hertz_chip holds from about 2 to 3 um"));
  Write("s.toml", Slot(3, "hertz_constant_bite"));
  EXPECT_THAT(Kerf("check s.toml").err,
              HasSubstr("warning: hertz_constant_bite gives the same force regardless of the bite: "
                        "thrust 1/122 of that measured"));
  Write("s.toml", Slot(3, "hertz_chip"));
  EXPECT_EQ(Kerf("check s.toml").err, "");
}

TEST_F(Law, FactorsAreForTheScenesTool) {
  // The thrust grows with the square root of the radius: four times the radius gives twice the thrust of the 22 mm
  // disc.
  Write("s.toml", Slot(9, "hertz_chip") + "[tool]\ndiameter_mm = 88.0\nteeth = 24\n");
  const ProgramResult text = Kerf("check s.toml");
  EXPECT_THAT(text.out,
              HasSubstr("thrust 3.1 times that measured at a bite of 2.5 um, 18 times that at 10 um (88 mm disc "
                        "with 24 teeth)"));
  EXPECT_THAT(text.err, HasSubstr("the bite reaches 3 um: hertz_chip holds at most up to about 2 um, where "
                                  "measurements begin, beyond it gives more than twice the measured thrust"));
  EXPECT_EQ(Json::parse(Kerf("check s.toml --json").out)["force"]["valid_bite_um"], Json({2.0, 2.0}));
}

TEST_F(Law, RunGivesTheEnergyAndWarnsOutsideTheWidenedInterval) {
  Write("s.toml", Slot(12, "hertz_chip"));
  const ProgramResult high = Kerf("run s.toml -o out");
  ASSERT_EQ(high.code, 0) << high.err;
  EXPECT_THAT(high.out, HasSubstr(DescribeAccuracy(ForceLaw("hertz_chip"), DiscSaw{})));
  EXPECT_THAT(high.out,
              testing::ContainsRegex("  cutting   [0-9.]+ J, [0-9.]+ J/mm3, [0-9.]+ mJ per tooth pass; cutting "
                                     "force = thrust / 1.6; range 0.8 to 6 J/mm3 .derived from"));
  EXPECT_THAT(high.err, HasSubstr("kerf: warning: the specific cutting energy is "));
  Write("s.toml", Slot(12, "edge_plus_chip"));
  const ProgramResult within = Kerf("run s.toml -o out --json");
  ASSERT_EQ(within.code, 0) << within.err;
  EXPECT_THAT(within.err, Not(HasSubstr("specific cutting energy")));
  EXPECT_TRUE(Json::parse(within.out)["cutting"]["within_widened"]);
}

TEST_F(Law, SlabModeStatesThePapersForceOfOneTooth) {
  std::string scene = Slot(6, "hertz_chip") + "[simulation]\nmode = \"slab\"\n[slab]\ndirection = [0.0, 0.0, -1.0]\n";
  scene.replace(scene.find("start_mm = [-9.0, 0.0, 9.0]"), 27, "start_mm = [0.0, 0.0, 12.0]");
  scene.replace(scene.find("end_mm = [9.0, 0.0, 9.0]"), 24, "end_mm = [0.0, 0.0, 10.0]");
  Write("s.toml", scene);
  const std::string said = "one tooth alone has the force of hertz_constant_bite: thrust 1/122 of that measured";
  EXPECT_THAT(Kerf("check s.toml").out, HasSubstr(said));
  EXPECT_THAT(Kerf("run s.toml -o out").out, HasSubstr(said));
}

TEST_F(Law, CheckCountsTheBoneThatNoToothCuts) {
  // The set of the teeth widens the kerf from 0.4 to 0.5 mm; teeth with a pitch of 0.8 mm and a stroke of 0.12 mm leave
  // most of the bone between them.
  const std::string block =
      "[bone]\nmodel = \"block\"\n[force]\nlaw = \"two_component\"\n[[path.stroke]]\n"
      "start_mm = [0, 0, 11]\nend_mm = [0, 0, 8]\nfeed_mm_per_s = 0.5\ndisc_normal = [0, 1, 0]\n";
  const auto check = [&](const std::string& tool) {
    Write("s.toml", block + "[tool]\n" + tool);
    return Json::parse(Kerf("check s.toml --json").out).at("force");
  };
  const Json saw = check("shape = \"reciprocating\"\nthickness_mm = 0.4\nset_mm = 0.05\n");
  const Json piezo = check("shape = \"piezo\"\nthickness_mm = 0.5\npitch_mm = 0.8\nstroke_mm = 0.12\n");
  const auto expected = [](const Json& force, double width_mm) {
    return force.at("at_top_bite").at("cutting_N").get<double>() / width_mm / force.at("top_bite_um").get<double>();
  };
  EXPECT_NEAR(saw.at("at_top_bite").at("specific_energy_J_per_mm3").get<double>() / expected(saw, 0.5), 1, 1e-9);
  EXPECT_NEAR(piezo.at("at_top_bite").at("specific_energy_J_per_mm3").get<double>() / expected(piezo, 0.5 * 0.8 / 0.12),
              1, 1e-9);
}

TEST_F(Law, LoopUsesTheActualSpindleSpeed) {
  Write("s.toml", Slot(6, "hertz_chip"));
  const ProgramResult loop = Kerf("loop s.toml --seconds 1 --virtual --hand H3 --do 0.001:rpm=3750 -o out --json");
  ASSERT_EQ(loop.code, 0) << loop.err;
  // The work is thrust / 1.6 times the speed of the rim, summed over the rows, one per tick.
  double thrust_Ns = 0;
  for (const test::ForceRow& row : test::ReadForces(folder_ / "out/forces.csv")) {
    thrust_Ns += 0.001 * row.at("thrust_sum_N");
  }
  const double work_J = 1e-3 * thrust_Ns / 1.6 * std::numbers::pi * 22 * 3750 / 60;
  ASSERT_GT(work_J, 0.1);
  // The rows have six digits; the first tick, before the change, is twice as fast.
  EXPECT_NEAR(Json::parse(loop.out)["cutting"]["work_J"].get<double>() / work_J, 1, 2e-3);
}

TEST_F(Law, LoopReportsAccuracyAndEnergy) {
  Write("s.toml", Slot(6, "hertz_chip"));
  const ProgramResult text = Kerf("loop s.toml --seconds 1 --virtual --hand H3");
  ASSERT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr(DescribeAccuracy(ForceLaw("hertz_chip"), DiscSaw{})));
  EXPECT_THAT(text.out, testing::ContainsRegex("  cutting   [0-9.]+ J, [0-9.]+ J/mm3"));
}

}  // namespace
}  // namespace kerf
