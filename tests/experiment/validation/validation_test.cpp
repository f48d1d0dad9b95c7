// The rigs and the verdicts. tests/experiment/validation/recompute.py recomputes every figure of the built-in sets.
#include "experiment/validation/validation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/files/files.h"
#include "experiment/validation/measured_sets.h"
#include "experiment/validation/validation_files.h"
#include "support/message_of.h"
#include "support/result_folder.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

MeasuredSet MakeSet(const std::string& rest, const std::string& calibrated = "[]") {
  return ParseMeasuredSet(
      "title = \"t\"\ncitation = \"c\"\ndoi = \"\"\nspecimen = \"s\"\nsetup = \"u\"\nlicence = "
      "\"l\"\ncalibrated = " +
          calibrated + "\n" + rest,
      "set.toml", "set");
}

Validation Compare(const std::string& law, const MeasuredSet& set) {
  return CompareWithMeasurements({ForceLaw(law)}, {set}, {});
}

// The bite on the rib differs from the nominal one by up to 0.13 % at its ends; the removed volume has an error of
// about 0.5 % from the grid (docs/physics.md). A wrong rib, feed or tool shape gives errors of several per cent.
TEST(ToothRun, ReachesTheNominalBiteAndTheForceOfTheLaw) {
  for (const ForceLawInfo* info : ForceLaws()) {
    for (const double width_mm : {0.25, 0.64}) {
      for (const double bite_um : {1.0, 2.5, 10.0, 50.0}) {
        const ToothRun run = RunTooth(ForceLaw(info->name), width_mm, bite_um, 4400);
        SCOPED_TRACE(std::string(info->name) + " at " + std::to_string(bite_um));
        EXPECT_NEAR(run.removed_bite_um, bite_um, 0.02 * bite_um);
        EXPECT_NEAR(run.reported_bite_um, bite_um, 0.002 * bite_um);
        EXPECT_GT(run.law_N, 0);
        EXPECT_NEAR(run.thrust_N, run.law_N, 0.005 * run.law_N);
      }
    }
  }
}

constexpr double kPi = std::numbers::pi;
constexpr BladeCut kLanninBlade{.width_mm = 0.64, .pitch_mm = 1.41, .stroke_mm = 3, .teeth = 1, .speed_mm_per_s = 1000};

/// Returns the mean over time of the law at the bite of a tooth whose mean over the way is `bite_um`, integrated over
/// half a period.
double CalcMeanThrust(const ForceLaw& law, const BladeCut& cut, double bite_um) {
  const LawOnTooth on_tooth(law, MakeReferenceDisc(cut.width_mm));
  // A half period brings a feed that fills the way: bite x stroke = pitch x feed of half a period.
  const double feed_per_rad = bite_um / 1000 * cut.stroke_mm / cut.pitch_mm / kPi;
  const double pitch = cut.pitch_mm / (0.5 * cut.stroke_mm);
  const double first_rad = std::acos(1 - pitch);
  double sum = 0;
  constexpr int kSteps = 20000;
  for (int i = 0; i < kSteps; ++i) {
    const double rad = kPi * (i + 0.5) / kSteps;
    const double since_rad = rad < first_rad ? 2 * rad : rad - std::acos(std::cos(rad) + pitch);
    sum += on_tooth({feed_per_rad * since_rad, cut.speed_mm_per_s, 1}).thrust_N;
  }
  return sum / kSteps;
}

// Where the thrust is not linear in the bite, the mean over a tick is not that of the bite in it: the error falls with
// the square of the ticks in a period, of which there are 16. The grid's error is 0.5 %, as in ToothRun.
TEST(BladeRun, ReachesTheNominalBiteAndTheMeanOfTheLawOverTheStroke) {
  for (const ForceLawInfo* info : ForceLaws()) {
    for (const double bite_um : {2.0, 10.0}) {
      SCOPED_TRACE(std::string(info->name) + " at " + std::to_string(bite_um));
      const BladeRun run = RunBladeAtBite(ForceLaw(info->name), kLanninBlade, bite_um);
      const double thrust_N = CalcMeanThrust(ForceLaw(info->name), kLanninBlade, bite_um);
      EXPECT_NEAR(run.bite_um, bite_um, 0.02 * bite_um);
      EXPECT_NEAR(run.thrust_N, thrust_N, 0.02 * thrust_N);
    }
  }
}

// Twice the speed has the same cut in half the time.
TEST(BladeRun, UnderAForceTheRateGrowsAsTheSpeed) {
  BladeCut fast = kLanninBlade;
  fast.speed_mm_per_s *= 2;
  for (const char* law : {"hertz_chip", "two_component"}) {
    const BladeRun run = RunBladeUnderForce(ForceLaw(law), kLanninBlade, 7);
    const BladeRun twice = RunBladeUnderForce(ForceLaw(law), fast, 7);
    EXPECT_NEAR(run.force_N, 7, 0.01);
    EXPECT_GT(run.removal_mm3_per_s, 1);
    EXPECT_NEAR(twice.removal_mm3_per_s / run.removal_mm3_per_s, 2, 1e-6);
  }
}

TEST(BladeRun, BelowTheForceOfItsEdgesABladeCutsNothing) {
  BladeCut five = kLanninBlade;
  five.teeth = 5;  // of 5.94 N each
  EXPECT_EQ(RunBladeUnderForce(ForceLaw("edge_plus_chip"), five, 7).removal_mm3_per_s, 0);
  EXPECT_GT(RunBladeUnderForce(ForceLaw("edge_plus_chip"), five, 40).removal_mm3_per_s, 1);
}

TEST(BladeRun, ATrendIsSawnIfItsSetGivesABlade) {
  const std::string trend =
      "[[trend]]\nquantity = \"thrust_N\"\nagainst = \"bite_um\"\nfrom = 2\nto = 10\nsign = "
      "\"rises\"\nobtained = \"read\"\n";
  const std::string tool = "[tool]\nkind = \"tooth\"\nwidth_mm = 0.64\n";
  EXPECT_TRUE(Compare("edge_plus_chip", MakeSet(tool + trend)).blades.empty());
  const Validation v = Compare("edge_plus_chip", MakeSet(tool + "pitch_mm = 1.41\nstroke_mm = 3\n" + trend));
  ASSERT_EQ(v.blades.size(), 1u);
  EXPECT_TRUE(v.blades[0].right);
  EXPECT_NEAR(v.blades[0].ratio, v.trends[0].ratio, 0.05 * v.trends[0].ratio);  // the law is linear in the bite
  EXPECT_THAT(test::MessageOf([&] { MakeSet(tool + "pitch_mm = 1.41\n" + trend); }), HasSubstr("stroke_mm"));
}

TEST(Rigs, ALawWithoutAnEdgeTermCutsAtAnyForceAndEdgePlusChipOnlyAboveItsEdgeForce) {
  // edge_plus_chip: 5.94 N for each tooth before it cuts.
  EXPECT_EQ(CountCarriedTeeth(ForceLaw("edge_plus_chip"), 0.64, 5.9), 0);
  EXPECT_EQ(CountCarriedTeeth(ForceLaw("edge_plus_chip"), 0.64, 7), 1);
  EXPECT_EQ(CountCarriedTeeth(ForceLaw("edge_plus_chip"), 0.64, 12), 2);
  EXPECT_GT(CountCarriedTeeth(ForceLaw("hertz_chip"), 0.64, 7), 100);
}

TEST(Rigs, ABladeBitesUntilItsTeethCarryTheForce) {
  const MeasuredSet set = MakeSet("[tool]\nkind = \"blade_force\"\nwidth_mm = 0.64\nteeth = 2\n");
  MeasuredConditions at;
  at.force_N = 20;
  at.speed_mm_per_s = 500;
  const Simulated rate = SimulateQuantity(ForceLaw("edge_plus_chip"), set, "removal_mm3_per_s", at);
  const double bite_mm = rate.value / (2 * 0.64 * 500);
  const ToothForces forces = LawOnTooth(ForceLaw("edge_plus_chip"), MakeReferenceDisc(0.64))({bite_mm, 500, 1});
  EXPECT_NEAR(2 * forces.thrust_N, 20, 1e-9 * 20);  // the bisection ends at the last bit of the bite
  at.force_N = 5;
  EXPECT_EQ(SimulateQuantity(ForceLaw("edge_plus_chip"), set, "removal_mm3_per_s", at).value, 0);
}

const char* const kToothAtSpeed = "[tool]\nkind = \"tooth\"\nwidth_mm = 0.64\n[conditions]\nspeed_mm_per_s = 4400\n";

TEST(Verdicts, ADifferenceIsCountedInStandardDeviations) {
  // edge_plus_chip gives 6.787 N at 2.5 um.
  const std::string value =
      "[[value]]\nquantity = \"thrust_N\"\nbite_um = 2.5\nobtained = \"read\"\nsd = 0.1\nvalue = ";
  const Validation near = Compare("edge_plus_chip", MakeSet(kToothAtSpeed + value + "6.6\n"));
  EXPECT_NEAR(near.values[0].difference_sd, 1.87, 0.05);  // the cut is within 0.1 % of the law
  EXPECT_EQ(near.values[0].agrees, true);
  EXPECT_EQ(near.counts[0].values, 1);
  EXPECT_EQ(near.counts[0].values_agree, 1);
  const Validation far = Compare("edge_plus_chip", MakeSet(kToothAtSpeed + value + "7.1\n"));
  EXPECT_NEAR(far.values[0].difference_sd, -3.13, 0.05);
  EXPECT_EQ(far.values[0].agrees, false);
  EXPECT_EQ(far.counts[0].values_agree, 0);
}

TEST(Verdicts, ARangeHasAnInsideAndAFactor) {
  const std::string value = "[[value]]\nquantity = \"thrust_N\"\nbite_um = 2.5\nobtained = \"read\"\n";
  const Validation inside = Compare("edge_plus_chip", MakeSet(kToothAtSpeed + value + "low = 6\nhigh = 7\n"));
  EXPECT_EQ(inside.values[0].verdict, "inside");
  const Validation below = Compare("edge_plus_chip", MakeSet(kToothAtSpeed + value + "low = 13.574\nhigh = 20\n"));
  EXPECT_EQ(below.values[0].verdict, "below, 0.5 times");
  EXPECT_EQ(below.values[0].agrees, false);
  const Validation alone = Compare("edge_plus_chip", MakeSet(kToothAtSpeed + value + "value = 6.787\n"));
  EXPECT_FALSE(alone.values[0].agrees.has_value());
  EXPECT_EQ(alone.counts[0].values, 0);
}

TEST(Verdicts, ASetUsedForCalibrationIsNeverCountedAsValidation) {
  const std::string rest = std::string(kToothAtSpeed) +
                           "[[value]]\nquantity = \"thrust_N\"\nbite_um = 2.5\nobtained = \"read\"\nlow = 6\nhigh = 7\n"
                           "[[trend]]\nquantity = \"thrust_N\"\nagainst = \"bite_um\"\nfrom = 2\nto = 10\nsign = "
                           "\"rises\"\nobtained = \"read\"\n";
  const Validation v = Compare("edge_plus_chip", MakeSet(rest, "[\"edge_plus_chip\"]"));
  EXPECT_EQ(v.counts[0].values, 0);
  EXPECT_EQ(v.counts[0].trends, 0);
  EXPECT_EQ(v.counts[0].calibration_values, 1);
  EXPECT_EQ(v.counts[0].calibration_trends_right, 1);
  EXPECT_EQ(Compare("hertz_chip", MakeSet(rest, "[\"edge_plus_chip\"]")).counts[0].values, 1);
  EXPECT_THAT(FormatValidationReport(v), HasSubstr("`edge_plus_chip` (calibration)"));
}

TEST(Verdicts, ATrendIsRightOrWrong) {
  const std::string trend = std::string(kToothAtSpeed) +
                            "[[trend]]\nquantity = \"energy_J_per_mm3\"\nagainst = \"bite_um\"\nfrom = 2\nto = 8\n"
                            "obtained = \"read\"\nsign = ";
  // The energy of hertz_chip grows with the square root of the bite.
  const Validation hertz = Compare("hertz_chip", MakeSet(trend + "\"falls\"\n"));
  EXPECT_EQ(hertz.trends[0].right, false);
  EXPECT_NEAR(hertz.trends[0].ratio, 2, 1e-9);
  EXPECT_EQ(Compare("hertz_chip", MakeSet(trend + "\"rises\"\n")).trends[0].right, true);
  EXPECT_EQ(Compare("edge_plus_chip", MakeSet(trend + "\"falls\"\n")).trends[0].right, true);
  EXPECT_EQ(Compare("edge_plus_chip", MakeSet(trend + "\"constant\"\n")).trends[0].right, false);
}

TEST(Verdicts, AMissingConditionIsNamed) {
  const Validation v = Compare("hertz_chip", MakeSet("[tool]\nkind = \"drill\"\ndiameter_mm = 3.2\npoint_deg = 118\n"
                                                     "[[value]]\nquantity = \"thrust_N\"\nrpm = 1000\nvalue = 1\n"
                                                     "obtained = \"read\"\n"));
  EXPECT_EQ(v.values[0].verdict, "not compared: feed_mm_per_min is not known");
  EXPECT_FALSE(v.values[0].agrees.has_value());
}

TEST(Verdicts, HertzLawsFailRowsAndTheReportShowsIt) {
  const Validation v = CompareWithMeasurements(ChooseLaws({"hertz_chip"}), BuiltInSets(), {});
  EXPECT_LT(v.counts[0].values_agree, v.counts[0].values);
  EXPECT_LT(v.counts[0].trends_right, v.counts[0].trends);
  const std::string report = FormatValidationReport(v);
  EXPECT_NE(report.find("**above, 9.07 times**"), std::string::npos);
  EXPECT_NE(report.find("**wrong: rises, x 11.2** *"), std::string::npos);
}

// edge_plus_chip is proportional to its two coefficients together.
TEST(SceneLaw, GivesTheNumbersOfItsLawAndOfItsValues) {
  const MeasuredSet set = MakeSet(std::string(kToothAtSpeed) +
                                      "[[value]]\nquantity = \"thrust_N\"\nbite_um = 2.5\nobtained = \"read\"\nlow = "
                                      "6\nhigh = 7\n[[trend]]\nquantity = \"thrust_N\"\nagainst = \"bite_um\"\nfrom = "
                                      "2\nto = 10\nsign = \"rises\"\nobtained = \"read\"\n",
                                  "[\"edge_plus_chip\"]");
  const ForceLaw law("edge_plus_chip");
  const Validation same = CompareWithMeasurements({law}, {set}, {}, SceneLaw{"mine", law});
  EXPECT_THAT(same.names, testing::ElementsAre("edge_plus_chip", "mine: edge_plus_chip"));
  ASSERT_EQ(same.values.size(), 2u);
  EXPECT_EQ(same.values[1].law, 1u);
  EXPECT_EQ(same.values[1].simulated.value, same.values[0].simulated.value);
  EXPECT_EQ(same.values[1].verdict, same.values[0].verdict);
  EXPECT_EQ(same.trends[1].ratio, same.trends[0].ratio);
  EXPECT_EQ(same.counts[1].calibration_values, 1);

  ForceLaw twice = law;
  for (const char* key : {"edge_N_per_mm", "chip_N_per_mm2"}) twice.Set(key, 2 * law.Get(key));
  const Validation own = CompareWithMeasurements({law}, {set}, {}, SceneLaw{"mine", twice});
  const double once_N = own.values[0].simulated.value;
  EXPECT_NEAR(own.values[1].simulated.value, 2 * once_N, 1e-9 * once_N);  // rounding of a sum of ticks
  EXPECT_EQ(own.counts[1].calibration_values, 0);                         // the values were not derived from the set
  EXPECT_EQ(own.counts[1].values, 1);
  EXPECT_THAT(FormatValidationReport(own), HasSubstr("`mine: edge_plus_chip` is the law of a scene"));
  EXPECT_THAT(FormatValidationReport(Compare("edge_plus_chip", set)), testing::Not(HasSubstr("law of a scene")));
  EXPECT_THAT(FormatValidationJson(own), HasSubstr("\"law\": \"mine: edge_plus_chip\""));
}

TEST(SceneLaw, AForceOfZeroHasNoRatio) {
  ForceLaw nothing("two_component");
  for (const char* key :
       {"thrust_edge_N_per_mm", "thrust_chip_N_per_mm2", "cutting_edge_N_per_mm", "cutting_chip_N_per_mm2"}) {
    nothing.Set(key, 0);
  }
  const MeasuredSet set = MakeSet(std::string(kToothAtSpeed) +
                                  "[[value]]\nquantity = \"thrust_per_cutting\"\nbite_um = 2.5\nobtained = \"read\"\n"
                                  "low = 1\nhigh = 2\n[[value]]\nquantity = \"thrust_N\"\nbite_um = 2.5\n"
                                  "obtained = \"read\"\nlow = 1\nhigh = 2\n");
  const Validation v = CompareWithMeasurements({}, {set}, {}, SceneLaw{"mine", nothing});
  EXPECT_EQ(v.values[0].verdict, "not compared: the law's cutting force is 0");
  EXPECT_EQ(v.values[1].verdict, "below, 0 times");
  EXPECT_THAT(FormatValidationReport(v), testing::Not(HasSubstr("nan")));
}

TEST(SceneLaw, ATableWithoutCorticalBoneIsRefused) {
  ForceTable table;
  for (const double bite_um : {2.5, 10.0}) table.Add({"cancellous", bite_um, 2.0, 1.0, "test"});
  ForceLaw law("tabulated");
  law.SetTable(std::make_shared<const ForceTable>(table));
  EXPECT_THAT(test::MessageOf([&] {
                CompareWithMeasurements({}, {}, {}, SceneLaw{"mine", law});
              }),
              HasSubstr("the table of the force law tabulated has no rows for cortical"));
}

TEST(Validation, UnknownLawsAreRefused) {
  EXPECT_EQ(ChooseLaws({}).size(), ForceLaws().size());
  EXPECT_EQ(ChooseLaws({"hertz_chip", "hertz_chip"}).size(), 1u);
  EXPECT_THAT(test::MessageOf([] { ChooseLaws({"hertz"}); }), HasSubstr("there is no force law \"hertz\""));
}

using ValidationFiles = test::ResultFolderTest;

TEST_F(ValidationFiles, AllFilesOfTheListAreWritten) {
  const Validation v = CompareWithMeasurements(ChooseLaws({"edge_plus_chip"}), BuiltInSets(), {});
  const std::vector<std::string> files = WriteValidation(v, folder_);
  EXPECT_EQ(files.back(), "validate.json");
  EXPECT_GE(std::count_if(files.begin(), files.end(), [](const std::string& f) { return f.ends_with(".png"); }), 6);
  for (const std::string& file : files) EXPECT_GT(ReadTextFile(folder_ + "/" + file).size(), 100u) << file;
}

}  // namespace
}  // namespace kerf
