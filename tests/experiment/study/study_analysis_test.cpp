// Tests of fronts, slopes and tables with known answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>

#include "experiment/study/made_up_study.h"
#include "experiment/study/pareto.h"
#include "experiment/study/pooled.h"
#include "experiment/study/study_words.h"

namespace kerf {
namespace {

using test::MakeCase;
using ::testing::HasSubstr;

TEST(ParetoFront, AgreesWithComparingAllPairs) {
  EXPECT_TRUE(rc::check([] {
    const auto draw = [] {
      return static_cast<double>(*rc::gen::inRange(0, 12));
    };  // few values, so that equal ones occur
    std::vector<CostAndError> points(*rc::gen::inRange<std::size_t>(0, 30));
    for (CostAndError& p : points) p = {draw(), draw()};
    std::vector<std::size_t> expected;
    for (std::size_t i = 0; i < points.size(); ++i) {
      bool beaten = false;
      for (std::size_t j = 0; j < points.size(); ++j) {
        const bool no_worse = points[j].cost <= points[i].cost && points[j].error <= points[i].error;
        const bool equal = points[j].cost == points[i].cost && points[j].error == points[i].error;
        beaten = beaten || (no_worse && (!equal || j < i));
      }
      if (!beaten) expected.push_back(i);
    }
    std::vector<std::size_t> front = FindParetoFront(points);
    for (std::size_t i = 1; i < front.size(); ++i) RC_ASSERT(points[front[i - 1]].cost < points[front[i]].cost);
    std::sort(front.begin(), front.end());
    RC_ASSERT(front == expected);
  }));
}

TEST(ParetoFront, LeavesOutPointsThatAreNotFinite) {
  EXPECT_EQ(FindParetoFront({{1, std::nan("")}, {2, 3}, {INFINITY, 1}}), std::vector<std::size_t>{1});
}

TEST(FitSlope, ExactPowerLawsGiveTheirExponentWhateverTheirHeights) {
  for (const double exponent : {-2.0, -1.0, 0.5, 1.0, 2.0}) {
    std::vector<SlopePath> paths;
    for (const double height : {0.01, 3.0, 40.0, 0.5}) {
      SlopePath path;
      for (const double number : {0.1, 0.2, 0.5, 0.7}) {
        if (height > 30 && number > 0.4) continue;  // a path with fewer numbers has the same slope
        path.numbers.push_back(number), path.errors.push_back(height * std::pow(number, exponent));
      }
      paths.push_back(path);
    }
    const Slope slope = FitSlope(paths).value();
    EXPECT_NEAR(slope.slope, exponent, 1e-12);
    EXPECT_NEAR(slope.interval->first, exponent, 1e-12);
    EXPECT_NEAR(slope.interval->second, exponent, 1e-12);
    EXPECT_EQ(slope.points, 14u);
  }
}

TEST(FitSlope, IntervalCoversPathsOfDifferentSlopesAndNarrowsWithTheirNumber) {
  const auto fit = [](int count) {
    std::vector<SlopePath> paths;
    for (int i = 0; i < count; ++i) {
      const double exponent = i % 2 == 0 ? 0.8 : 1.2;
      paths.push_back({{1, 2, 4}, {1, std::pow(2, exponent), std::pow(4, exponent)}});
    }
    return FitSlope(paths).value();
  };
  const Slope few = fit(6);
  const Slope many = fit(54);
  EXPECT_NEAR(few.slope, 1, 1e-12);
  // The mean of n slopes of 0.8 or 1.2 with equal probability has a standard deviation of 0.2 / sqrt(n), and 95 % are
  // within 1.96 of these. A percentile of 2000 draws is accurate to a tenth of that; few paths give steps of 0.4 / n.
  const double expected = 1.96 * 0.2 / std::sqrt(54.0);
  EXPECT_NEAR(many.interval->second - 1, expected, 0.15 * expected);
  EXPECT_NEAR(1 - many.interval->first, expected, 0.15 * expected);
  EXPECT_NEAR(few.interval->second - 1, 1.96 * 0.2 / std::sqrt(6.0), 0.4 / 6);
}

TEST(FitSlope, NeedsTwoNumbersAndForAnIntervalThreePaths) {
  EXPECT_FALSE(FitSlope({}));
  EXPECT_FALSE(FitSlope({{{1}, {1}}, {{2}, {3}}}));
  const Slope slope = FitSlope({{{1, 2}, {1, 2}}}).value();
  EXPECT_NEAR(slope.slope, 1, 1e-12);
  EXPECT_FALSE(slope.interval);
}

// Returns a study of two paths; the second is less accurate and slower.
StudyResults MakeSmallStudy() {
  StudyResults study;
  study.paths = {"a", "b"};
  study.knobs = {"voxel_mm", "rate_hz", "law", "method"};
  const auto add = [&](const char* knob, const char* value, double number, double error, double p99_us) {
    study.cases.push_back(MakeCase(Holding::kHand, "a", knob, value, number, 0.5 * error, 0.5 * p99_us));
    study.cases.push_back(MakeCase(Holding::kHand, "b", knob, value, number, error, p99_us));
  };
  // p99.9 is 1.4 times p99 (made_up_study.h).
  add("default", "", 0, 0.03, 200);
  add("voxel_mm", "0.05", 0.05, 0.01, 600);
  add("voxel_mm", "0.2", 0.2, 0.06, 100);
  add("rate_hz", "4000", 4000, 0.02, 100);  // 400 us for a millisecond
  add("law", "edge_plus_chip", 0, 0.001, 50);
  add("method", "slab", 0, 0.001, 5);
  study.cases.pop_back();  // on path a only
  ReferenceRecord reference;
  reference.path = "b";
  reference.error_bar = 0.002;
  study.references = {reference, reference};
  study.references.back().variant = "law=edge_plus_chip";
  return study;
}

TEST(Pooled, HasTheWorstErrorAndTheSlowestTimePerSimulatedMillisecond) {
  const StudyResults study = MakeSmallStudy();
  const std::vector<PooledSetting> settings = PoolSettings(study, Holding::kHand);
  ASSERT_EQ(settings.size(), 6u);
  EXPECT_TRUE(settings[0].is_default);
  EXPECT_EQ(settings[1].value, "0.05");
  EXPECT_EQ(settings[1].worst.value, 0.01);
  EXPECT_EQ(settings[1].worst_path, "b");
  EXPECT_EQ(settings[1].p99_us, 600);
  EXPECT_EQ(settings[3].value, "4000");
  EXPECT_DOUBLE_EQ(settings[3].p99_us, 400);
  EXPECT_TRUE(settings[4].worst.at_most);  // 0.001 on b, below its reference's 0.002
  EXPECT_EQ(settings[4].worst.value, 0.002);
  EXPECT_FALSE(settings[5].complete);
  EXPECT_TRUE(PoolSettings(study, Holding::kPath).empty());
}

TEST(Pooled, FrontLeavesOutOtherPhysicsAndSettingsNotRunOnEveryPath) {
  const StudyResults study = MakeSmallStudy();
  const std::vector<PooledSetting> settings = PoolSettings(study, Holding::kHand);
  EXPECT_EQ(FindFront(settings), (std::vector<std::size_t>{2, 0, 3, 1}));
}

TEST(Pooled, CurveHasTheDefaultsInTheirPlace) {
  const StudyResults study = MakeSmallStudy();
  const std::vector<PooledSetting> curve = CurveOf(PoolSettings(study, Holding::kHand), study.base, "voxel_mm");
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_EQ(curve[0].number, 0.05);
  EXPECT_TRUE(curve[1].is_default);
  EXPECT_EQ(curve[1].number, StudySettings().voxel_mm);
  EXPECT_EQ(curve[2].number, 0.2);
}

TEST(StudyTables, BestSettingsAtEqualTimeAndEqualErrorAreNamed) {
  const StudyResults study = MakeSmallStudy();
  const std::string times = EqualTimeTable(study, Holding::kHand);
  EXPECT_THAT(times, HasSubstr("| 0.25 ms | `voxel_mm = 0.2` | 6.00 % on `b` | 140 |"));
  EXPECT_THAT(times, HasSubstr("| 0.5 ms | the defaults | 3.00 % on `b` | 280 |"));
  EXPECT_THAT(times, HasSubstr("| 1 ms | `voxel_mm = 0.05` | 1.00 % on `b` | 840 |"));
  const std::string errors = EqualErrorTable(study, Holding::kHand);
  EXPECT_THAT(errors, HasSubstr("| 3.50 % | the defaults | 200 on `b` | 280 | 3.00 % |"));
  EXPECT_THAT(errors, HasSubstr("| 7.00 % | `voxel_mm = 0.2` | 100 on `b` | 140 | 6.00 % |"));
}

TEST(StudyTables, ErrorsBelowTheReferencesAreShownAsAtMost) {
  EXPECT_THAT(SettingsTable(MakeSmallStudy(), Holding::kHand), HasSubstr("| at most 0.200 % on `b` |"));
}

TEST(StudyTables, OmittedCasesAreNamedOnceWithTheReason) {
  StudyResults study = MakeSmallStudy();
  for (CaseRecord& record : study.cases) {
    if (record.knob == "rate_hz") record.state = CaseState::kFailed, record.why = "out of memory | here";
  }
  EXPECT_THAT(LeftOutTable(study), HasSubstr("| `rate_hz = 4000`, hand | a, b | failed | out of memory \\| here |"));
  EXPECT_THAT(LeftOutTable(MakeSmallStudy()), HasSubstr("Nothing was left out"));
}

TEST(StudyFindings, FollowFromTheFigures) {
  StudyResults study = MakeSmallStudy();
  std::string text = DescribeFindings(study, Holding::kHand);
  EXPECT_THAT(text, HasSubstr("**Force, p95, at most 3.50 %**: holds; the largest is 3.00 %, on `b`."));
  EXPECT_THAT(text, HasSubstr("The defaults are on the Pareto front"));
  // The gain is (3 - 1) points for 400 us and (3 - 2) for 200, so they are equal and listed in the study's order.
  EXPECT_THAT(text, HasSubstr("`voxel_mm = 0.05` gains the most accuracy per microsecond"));
  EXPECT_THAT(text, HasSubstr("0.500 points per 100 us"));
  for (CaseRecord& record : study.cases) {
    if (record.knob == "default" && record.path == "b")
      record.errors->force_p95 = 0.08, record.costs->tick.p99_us = 420;
  }
  text = DescribeFindings(study, Holding::kHand);
  EXPECT_THAT(text, HasSubstr("**Force, p95, at most 3.50 %**: does not hold on 1 of 2 paths: `b` (8.00 %)."));
  EXPECT_THAT(text, HasSubstr("**Tick, p99, under 300 us**: does not hold on 1 of 2 paths: `b` (420 us)."));
  EXPECT_THAT(text, HasSubstr("The defaults are not on the Pareto front: `rate_hz = 4000` has 2.00 % in 400 us"));
  EXPECT_THAT(text, HasSubstr("More accurate than the defaults in no more time"));
  // What a busy machine adds to some times is no finding.
  study.machine.load = 3;
  text = DescribeFindings(study, Holding::kHand);
  EXPECT_THAT(text, testing::Not(HasSubstr("in no more time")));
  EXPECT_THAT(text, HasSubstr("the machine was busy: its load before the run was 3.0"));
  EXPECT_THAT(text, testing::Not(HasSubstr("the slab takes")));
  EXPECT_EQ(EqualTimeTable(study, Holding::kHand), "");
  EXPECT_EQ(EqualErrorTable(study, Holding::kHand), "");
  EXPECT_TRUE(FindFront(PoolSettings(study, Holding::kHand)).empty());
  // A quarter of the cores may be busy.
  study.machine.cores = 12;
  EXPECT_FALSE(FindFront(PoolSettings(study, Holding::kHand)).empty());
}

TEST(StudyFindings, ClaimNothingAboutSettingsNotTimedOnEveryPath) {
  StudyResults study = MakeSmallStudy();
  for (CaseRecord& record : study.cases) {
    if (record.knob != "default" && record.path == "b") record.costs.reset();
  }
  const std::string text = DescribeFindings(study, Holding::kHand);
  EXPECT_THAT(text, HasSubstr("not timed on every path"));
  EXPECT_EQ(text.find("Pareto"), std::string::npos) << text;
  EXPECT_EQ(text.find("No single knob"), std::string::npos) << text;
}

TEST(StudyFindings, StateWhatTheSlabSaves) {
  const std::string text = DescribeFindings(MakeSmallStudy(), Holding::kHand);
  EXPECT_THAT(
      text,
      HasSubstr(
          "On the 1 path that both can run, the slab takes 2.50 us at p99 and the voxels take 100 us, 40.0 times as "
          "long"));
  EXPECT_THAT(text, HasSubstr("does not hold on this machine: at p99 they leave 90.0 % of the tick unused"));
}

// A knob's curve contains the study's base settings, not kerf's defaults.
TEST(PoolSettings, DefaultsAreTheBaseSettingsOfTheStudy) {
  StudyResults study;
  study.paths = {"a"};
  study.knobs = {"voxel_mm", "rate_hz"};
  study.base.voxel_mm = 0.2;
  study.base.rate_hz = 2000;
  study.cases = {MakeCase(Holding::kPath, "a", "default", "", 0, 0.02, 100),
                 MakeCase(Holding::kPath, "a", "voxel_mm", "0.1", 0.1, 0.01, 200),
                 MakeCase(Holding::kPath, "a", "voxel_mm", "0.4", 0.4, 0.04, 50),
                 MakeCase(Holding::kPath, "a", "rate_hz", "1000", 1000, 0.03, 100)};
  const std::vector<PooledSetting> settings = PoolSettings(study, Holding::kPath);
  const std::vector<PooledSetting> curve = CurveOf(settings, study.base, "voxel_mm");
  ASSERT_EQ(curve.size(), 3u);
  EXPECT_TRUE(curve[1].is_default);
  EXPECT_EQ(curve[1].number, 0.2);
  EXPECT_EQ(curve[1].value, "0.2");
  // There are at most two ticks of 100 us in a millisecond, and one at 1000 Hz.
  EXPECT_DOUBLE_EQ(curve[1].p99_us, 200);
  EXPECT_DOUBLE_EQ(CurveOf(settings, study.base, "rate_hz").front().p99_us, 100);
  // Errors are proportional to the voxel edge. With a base other than 0.2, they would not be.
  const KnobErrors errors = MakeKnobErrors(study, Holding::kPath, "voxel_mm").value();
  EXPECT_NEAR(errors.slope->slope, 1, 1e-12);
  EXPECT_EQ(DescribeBase(study.base), "`voxel_mm = 0.2`, `rate_hz = 2000`");
  EXPECT_EQ(DescribeBase({}), "");
}

TEST(FindReference, ReturnsTheReferenceWithTheSamePhysics) {
  StudyResults study;
  study.base.law = "edge_plus_chip";
  study.references.resize(3);
  for (ReferenceRecord& reference : study.references) reference.path = "a";
  study.references[0].variant = "";
  study.references[1].variant = "law=edge_plus_chip";
  study.references[2].variant = "law=edge_plus_chip,material=uniform";
  const auto find = [&](const char* knob, const char* value) {
    return FindReference(study, MakeCase(Holding::kHand, "a", knob, value, 0, 0.02, 100));
  };
  EXPECT_EQ(find("default", ""), &study.references[1]);
  EXPECT_EQ(find("voxel_mm", "0.2"), &study.references[1]);
  EXPECT_EQ(find("law", "hertz_chip"), &study.references[0]);
  EXPECT_EQ(find("material", "uniform"), &study.references[2]);
  // There is no matching reference: the case must not be compared with the reference of another material.
  EXPECT_EQ(find("material", "ct"), nullptr);
}

TEST(StudyFindings, OrdersOfTheMadeUpStudyAreRecovered) {
  const StudyResults study = test::MakeStudy();
  // The error of the temperature is 2 K times the square of the cell size (made_up_study.h).
  const KnobErrors heat = MakeKnobErrors(study, Holding::kHand, "heat_grid_mm").value();
  EXPECT_NEAR(heat.slope->slope, 2, 1e-9);
  // Points below the error bars are excluded from slopes. Otherwise the finest voxel would be included, at 0.03 of the
  // defaults' error.
  const KnobErrors voxel = MakeKnobErrors(study, Holding::kHand, "voxel_mm").value();
  EXPECT_NEAR(voxel.slope->slope, 0.95, 0.01);
  // A path on which only rounding is left has no curve.
  StudyResults exact = study;
  for (CaseRecord& record : exact.cases) {
    if (record.path == "worst" && record.errors) record.errors->force_p95 = 1e-13;
  }
  for (ReferenceRecord& reference : exact.references) {
    if (reference.path == "worst") reference.error_bar = 1e-15;
  }
  const KnobErrors others = MakeKnobErrors(exact, Holding::kHand, "voxel_mm").value();
  EXPECT_THAT(others.paths, testing::Not(testing::Contains("worst")));
  EXPECT_EQ(others.paths.size() + 1, voxel.paths.size());
  EXPECT_THAT(DefaultsTable(exact, Holding::kHand), HasSubstr("| worst | at most 0.00100 % |"));
  EXPECT_FALSE(MakeKnobErrors(study, Holding::kHand, "law"));
}

}  // namespace
}  // namespace kerf
