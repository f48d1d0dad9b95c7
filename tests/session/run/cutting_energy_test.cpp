// Tests that compare the specific cutting energy of a run with its closed form, and tests of its warnings.
#include "session/run/cutting_energy.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/files/files.h"
#include "cut/force/measured.h"
#include "cut/tool/words.h"
#include "session/run/make_bone.h"
#include "session/run/run_loop.h"
#include "session/run/run_scene.h"
#include "support/block_scene.h"
#include "support/result_folder.h"
#include "support/tooth_cut.h"

namespace kerf {
namespace {

/// Returns a scene with a kerf 2 mm deep through a whole block 24 mm long. The disc starts and ends outside the block.
std::string SlotScene(double feed_mm_per_s, const std::string& more) {
  return test::BlockToml({24, 2, 6}, 0.1) + "[material]\nkind = \"uniform\"\n" +
         test::StrokeToml({-19, 0, 9}, {19, 0, 9}, feed_mm_per_s, {0, 1, 0}) +
         "[output]\npictures = false\nbone = false\npieces = false\n" + more +
         (more.find("[force]") == std::string::npos ? "[force]\nlaw = \"hertz_chip\"\n" : "");
}

class CuttingEnergyRun : public test::ResultFolderTest {
 protected:
  RunSummary RunSlot(double feed_mm_per_s, const std::string& more = "") {
    return RunScene(ParseScene(SlotScene(feed_mm_per_s, more), "slot.toml"), folder_, {});
  }
};

/// Each point of the engaged arc cuts the whole length of the block with its own steady bite, so the work is that of
/// the steady cut, whatever its start and end. It is R / (ratio depth w h) times the integral of F(h sin phi) over the
/// arc, where h is the bite of the feed. (Rim speed times teeth per radian is R times the passes per second.)
double CalcClosedForm(const std::string& law, double feed_mm_per_s) {
  const DiscSaw saw;
  const ToothForce force = MakeToothForce(ForceLaw(law), saw);
  const double E_star = CalcReducedModulus(saw.E_MPa, saw.nu, 19300, 0.28);
  const double depth = 2;
  const double h = feed_mm_per_s / (saw.teeth * 125);
  const double alpha = std::acos(1 - depth / saw.radius_mm());
  constexpr int kIntervals = 10000;
  double integral = 0;
  for (int i = 0; i < kIntervals; ++i) {
    integral += force(h * std::sin(alpha * (i + 0.5) / kIntervals), Cortical(E_star)) * alpha / kIntervals;
  }
  return 1e-3 * saw.radius_mm() * integral / (1.6 * depth * saw.thickness_mm * h);
}

TEST(DescribeBites, UsesTheWordsOfTheTool) {
  const auto describe = [](const Tool& tool) {
    Scene scene = ParseScene(SlotScene(3, "[force]\nlaw = \"two_component\"\n"), "slot.toml");
    scene.tool.shape = tool;
    scene.tool.rpm = 3 * 60 / (0.005 * CountPassesPerTurn(tool));  // a bite of 5 um if the teeth pass evenly
    return DescribeBites(scene);
  };
  EXPECT_NE(describe(DiscSaw{}).find(", but bites along the rim begin at 0"), std::string::npos);
  EXPECT_NE(describe(BallBurr{}).find(", but bites along the surface begin at 0"), std::string::npos);
  EXPECT_NE(describe(FissureBur{}).find(", but bites along the side begin at 0"), std::string::npos);
  EXPECT_NE(describe(ReciprocatingBlade{}).find(", but bites in each stroke begin at 0"), std::string::npos);
  EXPECT_EQ(describe(TwistDrill{}).find("begin at 0"), std::string::npos) << "a lip bites equally deep everywhere";
  EXPECT_EQ(DescribeTooth(DiscSaw{}), "a tooth");
  EXPECT_EQ(DescribeTooth(TwistDrill{.tooth_width_mm = 0.25}), "0.25 mm of a lip");
  EXPECT_EQ(DescribeTeeth(PiezoInsert{}, 2.44), "2.4 teeth");
  EXPECT_EQ(DescribeTeeth(FissureBur{.tooth_width_mm = 0.5}, 3), "1.5 mm of the flutes");
}

TEST_F(CuttingEnergyRun, StraightCutMatchesTheClosedForm) {
  for (const char* law : {"hertz_chip", "hertz_constant_bite", "edge_plus_chip"}) {
    for (const double feed : {3.0, 12.0}) {
      const RunSummary summary = RunSlot(feed, fmt::format("[force]\nlaw = \"{}\"\n", law));
      ASSERT_TRUE(summary.cutting.specific_J_per_mm3.has_value());
      // Force and volume of a kerf are each accurate to a percent at 0.1 mm. The free edges of the kerf are rounded by
      // up to 0.07 mm each, of 24 mm, which is 0.6 % (docs/physics.md).
      const double expected = CalcClosedForm(law, feed);
      EXPECT_NEAR(*summary.cutting.specific_J_per_mm3 / expected, 1, 0.02) << law << " at " << feed;
      EXPECT_NEAR(*summary.cutting.work_J, *summary.cutting.specific_J_per_mm3 * summary.removed_mm3, 1e-9);
      // While any tooth is engaged, 3000 teeth pass per second.
      EXPECT_NEAR(*summary.cutting.pass_mJ, 1e3 * *summary.cutting.work_J / (3000 * summary.force.cutting_time_s),
                  1e-9);
      EXPECT_EQ(summary.cutting.ratio, 1.6);
      const auto json = nlohmann::json::parse(ReadTextFile(folder_ + "/summary.json"));
      EXPECT_EQ(json["cutting"]["specific_energy_J_per_mm3"], *summary.cutting.specific_J_per_mm3);
      EXPECT_EQ(json["cutting"]["tooth_pass_mJ"], *summary.cutting.pass_mJ);
      EXPECT_EQ(json["cutting"]["from_measured_forces_J_per_mm3"], nlohmann::json({0.83, 2.9}));
      EXPECT_EQ(json["cutting"]["widened_J_per_mm3"], nlohmann::json({0.8, 6.0}));
      EXPECT_EQ(json["cutting"]["within_widened"], expected > 0.8 && expected < 6);
      EXPECT_EQ(json["force"]["accuracy"], DescribeAccuracy(ForceLaw(law), DiscSaw{}));
    }
  }
}

// R / (depth w h) times the integral of the cutting force w (Kec + Kcc h) over the arc, written out here. No bite is
// below the crossover, except at the ends of the arc: the crossover is switched off.
TEST_F(CuttingEnergyRun, EnergyOfALawsOwnCuttingForceIsForceTimesWay) {
  const DiscSaw saw;
  for (const double feed : {6.0, 24.0}) {
    const double depth = 2;
    const double h = feed / (saw.teeth * 125);
    const double alpha = std::acos(1 - depth / saw.radius_mm());
    const double integral = saw.thickness_mm * (6.83 * alpha + 166 * h * (1 - std::cos(alpha)));
    const double expected = 1e-3 * saw.radius_mm() * integral / (depth * saw.thickness_mm * h);
    const std::string law = "[force]\nlaw = \"two_component\"\ncrossover_share = 0.0\n";
    const RunSummary plain = RunSlot(feed, law);
    EXPECT_EQ(plain.cutting.from, CuttingForceFrom::kLaw);
    EXPECT_FALSE(plain.cutting.ratio.has_value());
    // As above. In the middle of a slot, where the block's edges do not count, the power is within 1 % of the closed
    // form (tests/cut/path_sim/component_forces_test.cpp).
    EXPECT_NEAR(*plain.cutting.specific_J_per_mm3 / expected, 1, 0.02) << feed;
    // Power of the effect: the same force at the speed of rim and feed.
    const RunSummary effect = RunSlot(feed, law + "[effects.tangential_force]\n");
    EXPECT_EQ(effect.cutting.from, CuttingForceFrom::kEffect);
    EXPECT_NEAR(*effect.cutting.work_J / *plain.cutting.work_J, 1, 2e-3);
  }
}

TEST_F(CuttingEnergyRun, UsesPowerAndRatioOfTheEffect) {
  const RunSummary plain = RunSlot(6);
  const RunSummary same = RunSlot(6, "[effects.tangential_force]\n");
  EXPECT_EQ(same.cutting.from, CuttingForceFrom::kEffect);
  // The rim's speed is the spindle's, plus a thousandth of that for the feed.
  EXPECT_NEAR(*same.cutting.work_J / *plain.cutting.work_J, 1, 2e-3);
  const RunSummary half = RunSlot(6, "[effects.tangential_force]\nratio = 3.2\n");
  EXPECT_EQ(half.cutting.ratio, 3.2);
  EXPECT_NEAR(*half.cutting.work_J / *same.cutting.work_J, 0.5, 1e-6);
}

TEST_F(CuttingEnergyRun, WarnsOutsideTheWidenedIntervalOnly) {
  CuttingEnergy energy;
  const Scene scene = ParseScene(SlotScene(3, ""), "slot.toml");
  EXPECT_TRUE(FindEnergyWarnings(scene, energy).empty());  // no known energy, no warning
  for (const double within : {0.8, 2.65, 6.0}) {
    energy.specific_J_per_mm3 = within;
    EXPECT_TRUE(FindEnergyWarnings(scene, energy).empty()) << within;
  }
  energy.specific_J_per_mm3 = 0.79;
  EXPECT_EQ(FindEnergyWarnings(scene, energy).size(), 1u);
  energy.specific_J_per_mm3 = 2.84e-20;  // of a blade that is moved flat-on
  EXPECT_THAT(FindEnergyWarnings(scene, energy), testing::ElementsAre(testing::StartsWith("practically no tooth cut")));
  energy.specific_J_per_mm3 = -0.1;  // the feed is faster than the rim
  EXPECT_THAT(FindEnergyWarnings(scene, energy), testing::ElementsAre(testing::HasSubstr("bone drives the spindle")));
  energy.specific_J_per_mm3 = 10.6;
  EXPECT_EQ(FindEnergyWarnings(scene, energy),
            std::vector<std::string>{"the specific cutting energy is 10.6 J/mm3, outside 0.8 to 6 J/mm3 (derived "
                                     "from published forces at bites of 2.5 um and more: 0.83 to 2.9, with the "
                                     "upper bound doubled): the forces of hertz_chip are unrealistic"});
}

TEST_F(CuttingEnergyRun, NothingCutHasNoSpecificEnergy) {
  const std::string text = SlotScene(12, "");
  std::string above = text;
  for (std::size_t at; (at = above.find("9.0]")) != std::string::npos;) above.replace(at, 4, "20.0]");
  const RunSummary summary = RunScene(ParseScene(above, "slot.toml"), folder_, {});
  EXPECT_FALSE(summary.cutting.specific_J_per_mm3.has_value());
  EXPECT_TRUE(FindEnergyWarnings(ParseScene(above, "slot.toml"), summary.cutting).empty());
}

TEST_F(CuttingEnergyRun, BallNeedsTheEffect) {
  const std::string ball = "[tool]\nshape = \"ball\"\ndiameter_mm = 6.0\n";
  std::string text = SlotScene(12, ball);
  for (std::size_t at; (at = text.find("9.0]")) != std::string::npos;) text.replace(at, 4, "2.0]");
  const RunSummary without = RunScene(ParseScene(text, "ball.toml"), folder_, {});
  ASSERT_GT(without.removed_mm3, 1);
  EXPECT_FALSE(without.cutting.work_J.has_value());
  const RunSummary with = RunScene(ParseScene(text + "[effects.tangential_force]\n", "ball.toml"), folder_, {});
  EXPECT_GT(*with.cutting.work_J, 0);
}

TEST_F(CuttingEnergyRun, HeldSawLiesBetweenTheClosedFormsOfItsFeeds) {
  const Scene scene = ParseScene(SlotScene(6, "[hand]\nmodel = \"H3\"\n"), "slot.toml");
  LoopOptions options;
  options.seconds = 1.5;
  options.virtual_time = true;
  const LoopSummary summary = RunLoop(scene, options, {});
  ASSERT_TRUE(summary.cutting.has_value());
  ASSERT_TRUE(summary.cutting->specific_J_per_mm3.has_value());
  // The hand determines the feed. The result lies between those of the closed form at 1 and at 12 mm/s, which are
  // proportional to the square root of the feed.
  EXPECT_GT(*summary.cutting->specific_J_per_mm3, CalcClosedForm("hertz_chip", 1));
  EXPECT_LT(*summary.cutting->specific_J_per_mm3, CalcClosedForm("hertz_chip", 12));
}

}  // namespace
}  // namespace kerf
