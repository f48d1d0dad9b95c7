// Tests of a hand that breaks through the bone: the time before the breakthrough is judged, the drop is not, and
// instability before the breakthrough is still detected.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "experiment/stability/scenario_run.h"
#include "experiment/stability_study/stability.h"
#include "experiment/stability_study/stability_files.h"
#include "session/run/make_bone.h"
#include "support/block_scene.h"

namespace kerf {
namespace {

/// Returns a subject with a block of cancellous bone, 12 mm high by default. At 5 N the disc is through in 2.4 s,
/// during the scenario cut_5N. `cortex_mm`: thickness of the top layer, which is cortical bone.
StabilitySubject MakeSubject(double height_mm = 12, double cortex_mm = 0) {
  const Scene scene = ParseScene(
      test::BlockToml({16, 6, height_mm}, 0.25) + (cortex_mm > 0 ? test::LayerToml(cortex_mm, 24) : "") +
          test::LayerToml(height_mm - cortex_mm, 32) + "[tool]\nrpm = 7500.0\n" +
          test::StrokeToml({0, 0, 12}, {0, 0, -8}, 3, {0, 1, 0}) + "[coupling]\n[force]\nlaw = \"hertz_chip\"\n",
      "s.toml");
  const Bone bone = MakeSceneBone(scene, {});
  return MakeStabilitySubject(scene, MakeLoopSetup(scene), bone, FindFirstTouch(scene, bone));
}

ScenarioResult RunScenario(const StabilitySubject& subject, const std::string& name) {
  const auto& all = Scenarios();
  return std::find_if(all.begin(), all.end(), [&](const Scenario& s) { return s.name == name; })->run(subject, 1);
}

TEST(CutThrough, DropIsNotJudgedAsNoise) {
  const StabilitySubject subject = MakeSubject();
  for (const char* name : {"cut_5N", "cut_20N", "let_go", "frozen", "late_ticks", "jitter", "coarse_encoder"}) {
    const ScenarioResult result = RunScenario(subject, name);
    for (const StabilityFigure& f : result.figures) EXPECT_TRUE(f.holds()) << name << ": " << f.name << " " << f.value;
  }
  const ScenarioResult cut = RunScenario(subject, "cut_5N");
  ASSERT_TRUE(cut.cut_through_s.has_value());
  // The disc starts 0.3 mm above the block. With a radius of 11 mm and a block 16 mm long, its rim is through when its
  // centre is sqrt(11^2 - 8^2) mm above the lower face. At 5 N that takes between 2 and 3 s.
  EXPECT_GT(*cut.cut_through_s, 2);
  EXPECT_LT(*cut.cut_through_s, 3);
  EXPECT_EQ(DescribeCutThrough(cut).substr(0, 19), "cut through at t = ");
}

// The block is so thin that the tool is through before the scenario's own time. The interval that is left to judge
// contains the fault itself and the border between the two kinds of bone.
TEST(CutThrough, FaultsAndMaterialBordersAreNotJudgedAsNoise) {
  const StabilitySubject subject = MakeSubject(4.5, 0.5);
  for (const char* name : {"cut_20N", "frozen"}) {
    const ScenarioResult result = RunScenario(subject, name);
    EXPECT_TRUE(result.cut_through_s.has_value()) << name;
    EXPECT_EQ(result.unjudged.empty(), std::string(name) == "cut_20N") << name << " " << result.unjudged;
    for (const StabilityFigure& f : result.figures) EXPECT_TRUE(f.holds()) << name << ": " << f.name << " " << f.value;
  }
}

TEST(CutThrough, IsNotReportedForAToolStillInBone) {
  const ScenarioResult result = RunScenario(MakeSubject(), "cut_1N");
  EXPECT_FALSE(result.cut_through_s.has_value());
  EXPECT_EQ(DescribeCutThrough(result), "");
}

// A light hand holds a device without friction whose force is delayed by 12 ms, so the loop is unstable, and the tool
// also breaks through. With a gain of 2 it does so before the scenario's own time begins.
TEST(CutThrough, UnstableLoopThatBreaksThroughIsDetected) {
  for (const double gain : {1.0, 2.0}) {
    StabilitySubject subject = MakeSubject();
    subject.setup.hand = FindHandModel("H1");
    subject.setup.profile.friction_N = 0;
    subject.setup.delay_ticks = 12;
    subject.setup.loop_gain = gain;
    const ScenarioResult result = RunScenario(subject, "cut_5N");
    const bool noisy = std::any_of(result.figures.begin(), result.figures.end(), [](const StabilityFigure& f) {
      return f.name == "noise above 20 Hz" && !f.holds();
    });
    EXPECT_TRUE(result.cut_through_s.has_value()) << gain;
    EXPECT_TRUE(noisy) << gain << " " << DescribeCutThrough(result) << " " << result.unjudged;
  }
}

// With made-up ticks, the tool goes straight down through the block, or around its side, like a saw that its cutting
// force drives sideways. Both times it arrives behind the block, but only the first time has it cut through.
TEST(CutThrough, IsReportedOnlyOnTheLineOfTheFeed) {
  const StabilitySubject subject = MakeSubject();
  for (const bool round : {false, true}) {
    ScenarioRun run(subject, Scenario{"made_up", "", {}});
    const auto stay = [&](const Vec3& p_W) {
      ClosedLoopTick tick;
      tick.out.coupled.X_WT = subject.X_WT_start;
      tick.out.coupled.X_WT.p_AB = p_W;
      tick.out.coupled.removed_mm3 = 0.01;
      for (int i = 0; i < 20; ++i) run.Take(tick);
    };
    stay({0, 0, 5});
    EXPECT_FALSE(run.is_through());
    if (round) stay({25, 0, -6});
    EXPECT_FALSE(run.is_through());
    stay({0, 0, -30});
    EXPECT_EQ(run.is_through(), !round);
  }
}

TEST(CutThrough, IsWrittenToTheFiles) {
  StabilityStudy study;
  study.scenarios.resize(1);
  study.scenarios[0].name = "cut_5N";
  study.scenarios[0].cut_through_s = 2.39;
  EXPECT_NE(FormatCsv(FigureColumns(), ListFigures(study)).find("cut_5N,cut through,s,2.39,when,,not_asked\n"),
            std::string::npos);
  EXPECT_NE(FormatStabilityJson(study).find("\"cut_through_s\": 2.39"), std::string::npos);
  EXPECT_NE(FormatStabilityReport(study).find("| cut_5N | cut through at t = 2.39 s |"), std::string::npos);
}

}  // namespace
}  // namespace kerf
