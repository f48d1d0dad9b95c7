// Tests of the first contact of a scene's path with its bone, and of the judgement of measured figures.
#include "experiment/stability_study/stability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>

#include "experiment/stability_study/stability_files.h"
#include "kerf/error.h"
#include "session/run/make_bone.h"
#include "support/block_scene.h"
#include "support/message_of.h"

namespace kerf {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A block with its top face at z = 0.
const std::string kBlock = test::BlockToml({20, 8, 12}, 0.25);

std::string Stroke(const Vec3& start_mm, const Vec3& end_mm, const Vec3& normal) {
  return test::StrokeToml(start_mm, end_mm, 2, normal);
}

FirstTouch Touch(const std::string& text) {
  const Scene scene = ParseScene(kBlock + text, "s.toml");
  return FindFirstTouch(scene, MakeSceneBone(scene, {}));
}

std::string Refusal(const std::string& text) {
  return test::MessageOf([&] { Touch(text); }, "none");
}

// The rim of the disc of 22 mm diameter is on the face when its centre is 11 mm above it. The result is accurate to a
// tenth of a voxel, because the grid represents the face exactly.
TEST(FirstTouch, OfADiscIsWhereItsRimTouchesTheFace) {
  const FirstTouch down = Touch(Stroke({0, 0, 15}, {0, 0, 5}, {0, 1, 0}));
  EXPECT_NEAR(down.time_s, 2, 0.25 / 2 + 0.03);
  EXPECT_NEAR(down.X_WT.p_AB.z, 11 + 0.3 + 0.25 / 4, 0.03);
  EXPECT_NEAR(down.into_W.z, -1, 1e-12);
  const FirstTouch oblique = Touch(Stroke({-4, 0, 15}, {4, 0, 7}, {0, 1, 0}));
  EXPECT_NEAR(oblique.into_W.x, std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(oblique.into_W.z, -std::sqrt(0.5), 1e-9);
  EXPECT_NEAR(oblique.X_WT.p_AB.z, 11 + std::sqrt(0.5) * (0.3 + 0.25 / 4), 0.03);
}

TEST(FirstTouch, OfABallAndOfALaterStroke) {
  const std::string ball = "[tool]\nshape = \"ball\"\n";
  const FirstTouch touch =
      Touch(ball + Stroke({0, 0, 20}, {0, 0, 19}, {0, 1, 0}) + Stroke({0, -9, -6}, {0, 0, -6}, {0, 1, 0}));
  // The ball of 6 mm comes from the side in the second stroke, along y, which is its spindle, because a ball has teeth
  // there too.
  EXPECT_NEAR(touch.X_WT.p_AB.y, -4 - 3 - 0.3 - 0.25 / 4, 0.05);
  EXPECT_NEAR(touch.into_W.y, 1, 1e-12);
}

// The bone is 8 mm thick and in the middle of a rim 10 mm thick, so neither flat of the disc comes near it.
TEST(FirstTouch, OfADiscThatIsThickerThanTheBone) {
  const FirstTouch touch = Touch("[tool]\nthickness_mm = 10.0\n" + Stroke({0, 0, 15}, {0, 0, 5}, {0, 1, 0}));
  EXPECT_NEAR(touch.X_WT.p_AB.z, 11 + 0.3 + 0.25 / 4, 0.03);
}

TEST(FirstTouch, IsRefusedWhereThereIsNothingToExamine) {
  EXPECT_THAT(Refusal(Stroke({0, 0, 20}, {0, 0, 12}, {0, 1, 0})), HasSubstr("never touches the bone"));
  EXPECT_THAT(Refusal(Stroke({0, 0, 8}, {0, 0, 4}, {0, 1, 0})), HasSubstr("begins inside the bone"));
  EXPECT_THAT(Refusal(Stroke({0, 6, -3}, {0, 0, -3}, {0, 1, 0})), HasSubstr("with its flat"));
}

// A tool that starts as close as possible to the face and leaves it touches the bone only with the next stroke.
TEST(FirstTouch, LeavingAFaceIsNotATouch) {
  const FirstTouch touch = Touch(Stroke({0, 0, 11}, {0, 0, 13}, {0, 1, 0}) + Stroke({5, 0, 13}, {5, 0, 10}, {0, 1, 0}));
  EXPECT_NEAR(touch.X_WT.p_AB.x, 5, 1e-9);
  EXPECT_NEAR(touch.into_W.z, -1, 1e-12);
}

TEST(StabilitySubject, IsTheSceneAsTheLoopRunsIt) {
  const Scene scene = ParseScene(kBlock +
                                     "[coupling]\nstiffness_N_per_mm = 500.0\n[loop]\nrate_hz = 500.0\n[hand]\nmodel = "
                                     "\"H1\"\n[device]\nprofile = \"touch\"\n" +
                                     Stroke({0, 0, 15}, {0, 0, 5}, {0, 1, 0}),
                                 "s.toml");
  const Bone bone = MakeSceneBone(scene, {});
  const LoopSetup setup = MakeLoopSetup(scene);
  const StabilitySubject subject = MakeStabilitySubject(scene, setup, bone, FindFirstTouch(scene, bone));
  EXPECT_EQ(subject.setup.coupled.coupling.stiffness_N_per_mm, setup.fitted.coupling.stiffness_N_per_mm);
  EXPECT_LT(subject.setup.coupled.coupling.stiffness_N_per_mm, 500);
  EXPECT_EQ(subject.setup.profile.name, "touch");
  EXPECT_EQ(subject.setup.hand.name, "H1");
  EXPECT_EQ(subject.setup.period_s, 0.002);
  EXPECT_EQ(subject.setup.force_map.expected_peak_N, 28);
  EXPECT_EQ(subject.bone.CalcHash(), bone.CalcHash());  // small enough to hash all of it
}

StabilityFigure Figure(double value, double bound, bool at_most = true) {
  return {"figure", "mN", value, bound, at_most};
}

TEST(Nearness, IsAboveOneExactlyIfABoundIsViolated) {
  EXPECT_DOUBLE_EQ(CalcNearness(Figure(5, 20)), 0.25);
  EXPECT_EQ(CalcNearness(Figure(20, 20)), 1);
  EXPECT_DOUBLE_EQ(CalcNearness(Figure(60, 20)), 3);
  EXPECT_DOUBLE_EQ(CalcNearness(Figure(8, 2, false)), 0.25);
  EXPECT_DOUBLE_EQ(CalcNearness(Figure(1, 2, false)), 2);
  EXPECT_EQ(CalcNearness(Figure(0, 0)), 0);
  StabilityFigure clamped = Figure(20, 20);
  clamped.clamped = true;
  EXPECT_EQ(CalcNearness(clamped), 0);
  clamped.value = 21;
  EXPECT_GT(CalcNearness(clamped), 1);
  EXPECT_GT(CalcNearness(Figure(1e-9, 0)), 1);
  EXPECT_GT(CalcNearness(Figure(0, 2, false)), 1);
  // The figure is an energy whose lower bound is slightly below zero.
  EXPECT_LE(CalcNearness(Figure(-1e-6, -1e-3, false)), 1);
  EXPECT_GT(CalcNearness(Figure(-1, -1e-3, false)), 1);
  EXPECT_LE(CalcNearness(Figure(5, -1e-3, false)), 1);
  for (const double value : {kNaN, 0.0, -1.0, 1.0}) {
    for (const double bound : {kNaN, 0.0, -2.0, 2.0}) {
      for (const bool at_most : {true, false}) {
        const StabilityFigure f = Figure(value, bound, at_most);
        EXPECT_EQ(CalcNearness(f) > 1, !f.holds()) << value << " " << bound << " " << at_most;
      }
    }
  }
}

ScenarioResult Scenario(const std::string& name, std::vector<StabilityFigure> figures) {
  ScenarioResult result;
  result.name = name;
  result.what = "made up";
  result.figures = std::move(figures);
  result.time_s = {0, 0.001, 0.002};
  result.force_N = {0, 1, 0.5};
  return result;
}

HandMargins Margin(const std::string& hand, bool own, bool linear, double gain, int delay_ticks) {
  return {hand, own, HeldState::kCutting, linear, true, {gain, false, delay_ticks, false, {}}};
}

StabilityStudy MakeStudy() {
  StabilityStudy study;
  study.scene = "made_up";
  study.setup.hand.name = "H3";
  study.setup.profile.name = "omega_6";
  study.rate_hz = 1000;
  study.scenarios = {Scenario("calm", {Figure(2, 20)}), Scenario("near", {Figure(1, 20), Figure(19, 20)})};
  ScenarioResult left_out;
  left_out.name = "tilt";
  left_out.what = "the device drives no torques";
  left_out.skipped = true;
  study.scenarios.push_back(left_out);
  study.margins = {Margin("H1", false, false, 1.2, 0), Margin("H1", false, true, 0.6, 0),
                   Margin("H3", true, false, 2, 1), Margin("H3", true, true, 4, 3), Margin("H0", false, false, 0.5, 0)};
  study.map = {{1, 2},
               {0, 0.01, 0.02},
               {Behaviour::kStable, Behaviour::kUnstable, Behaviour::kStable, Behaviour::kLimitCycle,
                Behaviour::kStable, Behaviour::kStable}};
  study.map_linear = study.map.behaviour;
  study.map_linear.back() = Behaviour::kUnstable;
  study.setup.fitted.coupling.stiffness_N_per_mm = 1;
  study.limits.max_stiffness_N_per_mm = 11;
  study.limits.max_damping_Ns_per_mm = 0.01;
  study.limits.own_damping_Ns_per_mm = 0.002;
  study.limits.per_s = 2000;
  return study;
}

// The examination is stopped after the first scenario or margin. With one thread, no other is examined.
TEST(ExamineStability, ReturnsTheResultsSoFarWhenStopped) {
  const Scene scene = ParseScene(kBlock + Stroke({0, 0, 12}, {0, 0, 4}, {0, 1, 0}), "s.toml");
  std::atomic<bool> stop{false};
  StabilityOptions options;
  options.quick = true;
  options.threads = 1;
  options.stop = &stop;
  const StabilityStudy study = ExamineStability(scene, options, [&](const std::string& stage, double fraction) {
    if ((stage == "scenarios" || stage == "margins") && fraction > 0) stop = true;
  });
  EXPECT_FALSE(study.complete);
  EXPECT_TRUE(study.map.behaviour.empty());
  EXPECT_EQ(study.CountScenarios().judged + study.CountMargins().judged, 1);
  EXPECT_THAT(DescribeVerdict(study), HasSubstr("Stopped before all cases were examined; stable so far"));
}

TEST(JudgeStability, IsStableIfEveryBoundIsMet) {
  StabilityStudy study = MakeStudy();
  JudgeStability(study);
  EXPECT_THAT(study.findings, ElementsAre());
  EXPECT_TRUE(study.stable());
  study.complete = false;
  EXPECT_FALSE(study.stable());
}

TEST(JudgeStability, NamesEachFigureAndMarginThatDoesNotHold) {
  StabilityStudy study = MakeStudy();
  study.scenarios[0].figures[0].value = 30;
  study.scenarios[1].figures[1].value = kNaN;
  study.margins[0].margins.gain = 0.9;       // another hand: unstable
  study.margins[2].margins.delay_ticks = 0;  // the scene's hand: no tick of delay
  study.margins[3].margins.gain = 1.99;      // the scene's hand, linear
  JudgeStability(study);
  EXPECT_THAT(study.findings, ElementsAre("calm: figure is 30 mN, but must be at most 20",
                                          HasSubstr("near: figure is nan mN"), HasSubstr("in the hand H1: it is not"),
                                          HasSubstr("tolerates 0 ticks of additional delay, at least 1 required"),
                                          HasSubstr("the gain margin is 1.99, at least 2 required")));
  EXPECT_FALSE(study.stable());
  // A handle that is released has no required margins, unless it is the scene's own hand.
  study = MakeStudy();
  study.margins.back().own = true;
  JudgeStability(study);
  EXPECT_THAT(study.findings, ElementsAre(HasSubstr("in the hand H0: the gain margin is 0.5, at least 2 required")));
  // A scenario without measured figures has shown nothing.
  study = MakeStudy();
  study.scenarios[0].figures.clear();
  JudgeStability(study);
  EXPECT_THAT(study.findings, ElementsAre("calm: nothing could be measured"));
}

// A scenario or margin that could not be judged is neither stable nor unstable, and it is counted.
TEST(JudgeStability, CountsWhatCouldNotBeJudged) {
  StabilityStudy study = MakeStudy();
  study.scenarios[0].unjudged = "The tool was through the bone too soon for the noise to be judged.";
  study.margins[3].margins = {};
  study.margins[3].margins.unjudged = "the tool cuts through the bone too soon";
  study.margins[2].margins.delay_ticks = 0;  // beyond the delays that could be tried: undecided
  study.margins[2].margins.delay_beyond = true;
  JudgeStability(study);
  EXPECT_THAT(study.findings, ElementsAre());
  EXPECT_TRUE(study.stable());
  EXPECT_EQ(study.scenarios[0].judgement(), Judgement::kNotJudged);
  // The skipped scenario, another hand without friction, and a released handle are not required.
  EXPECT_EQ(DescribeVerdict(study), "Stable as far as could be judged: 1 of 2 scenarios, 1 of 3 margins.");
  EXPECT_THAT(FormatCsv(MarginColumns(), ListMargins(study)), HasSubstr("H3,cutting,true,,,,,not_judged\n"));
  const std::string report = FormatStabilityReport(study);
  EXPECT_THAT(report, HasSubstr("| calm | The tool was through the bone too soon for the noise to be judged. | | | not "
                                "judged |"));
  EXPECT_THAT(report, HasSubstr("not judged: the tool cuts through the bone too soon | not judged |"));
  // A figure that violates its bound still counts as a failure.
  study.scenarios[0].figures[0].value = 30;
  EXPECT_EQ(study.scenarios[0].judgement(), Judgement::kBroken);
  JudgeStability(study);
  EXPECT_THAT(study.findings, ElementsAre(HasSubstr("calm: figure is 30 mN")));
}

TEST(JudgeStability, IsNotStableIfNothingWasExamined) {
  StabilityStudy study = MakeStudy();
  for (ScenarioResult& scenario : study.scenarios) scenario.skipped = true;
  for (HandMargins& m : study.margins) m.done = false;
  study.complete = false;
  JudgeStability(study);
  EXPECT_FALSE(study.stable());
  EXPECT_EQ(DescribeVerdict(study), "Stopped before anything was examined.");
  EXPECT_THAT(FormatStabilityJson(study), HasSubstr("\"stable\": null"));
  study.complete = true;
  EXPECT_FALSE(study.stable());
  EXPECT_THAT(FormatStabilityJson(study), HasSubstr("\"stable\": null"));
}

// Every state requires a gain of 2 and a delay of one tick.
TEST(JudgeProfiles, UsesTheWorstState) {
  ProfileMargins row;
  row.hand = row.fitted_to = "H3";
  row.margins.fill({3, false, 1, false, {}});
  EXPECT_EQ(Judge(row), Judgement::kHolds);
  row.margins[1].unjudged = "the tool cuts through the bone too soon";
  EXPECT_EQ(Judge(row), Judgement::kNotJudged);
  EXPECT_THAT(FormatProfilesTable({row}), HasSubstr("3 / 1, not all states judged |"));
  row.margins[2].gain = 1.5;
  EXPECT_EQ(Judge(row), Judgement::kBroken);
  row.fitted_to = "H1";
  EXPECT_EQ(Judge(row), Judgement::kNotAsked);
}

TEST(DescribeVerdict, NamesTheExaminedStiffnessIfItWasLowered) {
  StabilityStudy study = MakeStudy();
  study.setup.fitted.coupling.stiffness_N_per_mm = 0.15;
  study.setup.asked_stiffness_N_per_mm = 1000;
  EXPECT_EQ(DescribeVerdict(study), "Stable at 0.15 N/mm (1000 requested).");
  study.findings = {"something"};
  EXPECT_EQ(DescribeVerdict(study), "Not stable at 0.15 N/mm (1000 requested):");
}

TEST(RankScenarios, PutsTheWorstFirst) {
  StabilityStudy study = MakeStudy();
  std::vector<WorstFigure> ranked = RankScenarios(study);
  ASSERT_EQ(ranked.size(), 2U);
  EXPECT_EQ(ranked[0].scenario->name, "near");
  EXPECT_EQ(ranked[0].figure->value, 19);
  study.scenarios[0].figures[0].value = 21;
  EXPECT_EQ(RankScenarios(study)[0].scenario->name, "calm");
  EXPECT_EQ(DescribeWorst(study), "calm, figure 21 mN, at most 20");
}

TEST(StabilityFiles, TablesHaveARowForEachFigure) {
  StabilityStudy study = MakeStudy();
  JudgeStability(study);
  EXPECT_EQ(FormatCsv(FigureColumns(), ListFigures(study)),
            "scenario,figure,unit,value,kind,bound,holds\ncalm,figure,mN,2,at_most,20,true\n"
            "near,figure,mN,1,at_most,20,true\nnear,figure,mN,19,at_most,20,true\n");
  EXPECT_THAT(FormatCsv(MarginColumns(), ListMargins(study)),
              HasSubstr(std::string("H1,") + ToString(HeldState::kCutting) + ",false,1.2,false,0,false,true\n"));
  // A released handle has no required margins.
  EXPECT_THAT(FormatCsv(MarginColumns(), ListMargins(study)),
              HasSubstr("H0,cutting,false,0.5,false,0,false,not_asked\n"));
  // The rule gives 2 (0.002 + 0.01) / 0.001 = 24.
  EXPECT_THAT(FormatMapCsv(study), HasSubstr("\n0.01,2,0.01,2,24,limit cycle,limit cycle\n"));
  const std::string report = FormatStabilityReport(study);
  EXPECT_THAT(report, HasSubstr("**Stable.**"));
  EXPECT_THAT(report, HasSubstr("| tilt | the device drives no torques |"));
  EXPECT_THAT(report, HasSubstr("| near | figure | 19 mN | at most 20 | yes |"));
  study.scenarios[1].figures[1].value = 21;
  JudgeStability(study);
  EXPECT_THAT(FormatStabilityReport(study), HasSubstr("**Not stable:**"));
  EXPECT_THAT(FormatStabilityReport(study), HasSubstr("| near | figure | 21 mN | at most 20 | **no** |"));
}

// Checks the series of the map: points by outcome, the rule, the device's limits, and the scene's gains.
TEST(StabilityFigures, MapHasEveryPointOnceAndTheRule) {
  StabilityStudy study = MakeStudy();
  const PlotSpec plot = MakeMapPlot(study);
  std::size_t points = 0;
  for (std::size_t i = 0; i < 4; ++i) points += plot.series[i].x.size();
  EXPECT_EQ(points, 6U);
  EXPECT_EQ(plot.series[0].label, "stable");
  EXPECT_EQ(plot.series[0].x.size(), 3U);
  EXPECT_THAT(plot.series[1].x, ElementsAre(0.02));  // stable, but not without friction
  EXPECT_THAT(plot.series[1].y, ElementsAre(2));
  EXPECT_THAT(plot.series[2].x, ElementsAre(0.01));
  EXPECT_THAT(plot.series[2].y, ElementsAre(2));
  EXPECT_THAT(plot.series[3].x, ElementsAre(0));
  const PlotSeries& rule = plot.series[4];
  for (std::size_t i = 0; i < rule.x.size(); ++i) EXPECT_NEAR(rule.y[i], 2000 * (0.002 + rule.x[i]), 1e-9);
  unsetenv("DISPLAY");
  EXPECT_NO_THROW(RenderPlot(plot));
  for (const MarginKind kind : {MarginKind::kGain, MarginKind::kDelay}) {
    const PlotSpec margins = MakeMarginPlot(study, kind);
    EXPECT_THAT(margins.x.names, ElementsAre("H1", "H3 (the scene's)", "H0"));
    // There are a large and a small dot for each state. Those of cutting are the third and the fourth series.
    EXPECT_EQ(margins.series[2].x.size(), 3U);
    EXPECT_EQ(margins.series[3].x.size(), 2U);
    EXPECT_THAT(margins.series[2].y,
                kind == MarginKind::kGain ? ElementsAre(1.2, 2.0, 0.5) : ElementsAre(0.0, 1.0, 0.0));
    EXPECT_NO_THROW(RenderPlot(margins));
  }
  EXPECT_NO_THROW(RenderPlot(MakeScenarioPlot(study, RankScenarios(study)[0])));
}

}  // namespace
}  // namespace kerf
