// Tests of points and totals.
#include "session/score/measures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>

#include "kerf/error.h"

namespace kerf {
namespace {

constexpr ExerciseKind kKinds[] = {ExerciseKind::kGroove,      ExerciseKind::kStopBeforeFar, ExerciseKind::kBicortical,
                                   ExerciseKind::kBesideCanal, ExerciseKind::kFollowLine,    ExerciseKind::kOsteotomy};

/// Returns the sheet of a complete and perfect cut.
ScoreSheet Perfect(ExerciseKind kind) {
  ScoreSheet sheet = MakeSheet(kind);
  for (MeasureRow& row : sheet.rows) {
    row.value = 0;
    if (row.half == 0) row.half = 10;
  }
  SetValue(sheet, "cut_share", 1);
  CalcTotal(sheet);
  return sheet;
}

TEST(Measures, OnlyMeasuresWithPublishedEvidenceAreScored) {
  for (const ExerciseKind kind : kKinds) {
    ASSERT_FALSE(GoalsOf(kind).empty());
    for (const Goal& goal : GoalsOf(kind)) {
      EXPECT_TRUE(FindMeasure(goal.key).scored()) << goal.key;
      EXPECT_GT(goal.weight, 0);
    }
  }
}

TEST(Measures, HaveKeysOfTheirOwnAndFormulas) {
  std::set<std::string> keys;
  for (const MeasureInfo& info : Measures()) {
    EXPECT_TRUE(keys.insert(info.key).second) << info.key;
    EXPECT_NE(std::string(info.formula), "");
    EXPECT_NE(std::string(info.name), "");
  }
  EXPECT_THROW(FindMeasure("beauty"), Error);
}

TEST(Total, Is100ForAPerfectCutAnd0ForNoCut) {
  for (const ExerciseKind kind : kKinds) {
    ScoreSheet sheet = Perfect(kind);
    EXPECT_DOUBLE_EQ(sheet.total.value(), 100);
    SetValue(sheet, "cut_share", 0);
    CalcTotal(sheet);
    EXPECT_EQ(sheet.total.value(), 0);
  }
  ScoreSheet none = MakeSheet({});
  CalcTotal(none);
  EXPECT_FALSE(none.total);
}

TEST(Total, DecreasesWithEachScoredMeasure) {
  for (const ExerciseKind kind : kKinds) {
    for (const Goal& goal : GoalsOf(kind)) {
      double last = 101;
      for (const double value : {0.0, 0.01, 0.3, 1.0, 3.0}) {
        ScoreSheet sheet = Perfect(kind);
        SetValue(sheet, goal.key, -value);  // the sign of an offset is ignored
        CalcTotal(sheet);
        EXPECT_LT(sheet.total.value(), last) << goal.key << " = " << value;
        last = sheet.total.value();
      }
    }
  }
}

// The text leaves out residues of rounding, the JSON does not.
TEST(Sheet, ResiduesOfRoundingAreZeroInText) {
  ScoreSheet sheet = Perfect(ExerciseKind::kGroove);
  SetValue(sheet, "plane_offset_mm", -5.782e-6);
  SetValue(sheet, "plane_angle_deg", 0.00123);
  const std::string text = FormatSheet(sheet);
  EXPECT_THAT(text, testing::Not(testing::HasSubstr("e-0")));
  EXPECT_THAT(text, testing::HasSubstr("0.00123"));
  EXPECT_EQ(SheetJson(sheet)["measures"]["plane_offset_mm"]["value"], -5.782e-6);
}

TEST(Total, UnmeasuredValuesGetNoPoints) {
  ScoreSheet sheet = Perfect(ExerciseKind::kGroove);
  SetValue(sheet, "plane_offset_mm", {});
  CalcTotal(sheet);
  EXPECT_LT(sheet.total.value(), 100);
  EXPECT_GT(sheet.total.value(), 50);
}

TEST(Points, AreHalvedAtTheHalfValue) {
  EXPECT_DOUBLE_EQ(CalcPoints(0, 3), 1);
  EXPECT_DOUBLE_EQ(CalcPoints(3, 3), 0.5);
  EXPECT_DOUBLE_EQ(CalcPoints(-6, 3), 0.25);
}

TEST(Points, AreNotLostWithinTheGoal) {
  EXPECT_DOUBLE_EQ(CalcPoints(0, 10, 5), 1);
  EXPECT_DOUBLE_EQ(CalcPoints(5, 10, 5), 1);
  EXPECT_DOUBLE_EQ(CalcPoints(10, 10, 5), 0.5);
  EXPECT_DOUBLE_EQ(CalcPoints(15, 10, 5), 0.25);
}

TEST(Sheet, IsWrittenAsTableJsonCsvAndPage) {
  ScoreSheet sheet = Perfect(ExerciseKind::kBesideCanal);
  sheet.title = "<b>Cut & go</b>";
  const auto json = nlohmann::json::parse(FormatSheetJson(sheet));
  EXPECT_EQ(json["exercise"], "beside_canal");
  EXPECT_EQ(json["total"], 100);
  EXPECT_EQ(json["measures"].size(), Measures().size());
  EXPECT_EQ(json["measures"]["plane_offset_mm"]["unit"], "mm");
  EXPECT_THAT(FormatSheet(sheet), testing::HasSubstr("100.0 out of 100"));
  EXPECT_THAT(FormatSheetCsv(sheet), testing::HasSubstr("\ntotal,"));
  const std::string html = FormatSheetHtml(sheet);
  EXPECT_THAT(html, testing::HasSubstr("&lt;b&gt;Cut &amp; go"));
  EXPECT_THAT(html, testing::Not(testing::HasSubstr("<b>Cut")));
  EXPECT_THAT(html, testing::Not(testing::HasSubstr("http")));  // needs no external resource
}

}  // namespace
}  // namespace kerf
