// Tests of `kerf bench growth` with few ticks. Times are not checked because they depend on the machine; the work of a
// tick and the memory do not.
#include "experiment/bench/growth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <string>

#include "base/files/files.h"
#include "support/result_folder.h"

namespace kerf {
namespace {

/// Returns the plan for a quantity, with only two of its cuts.
GrowthPlan PlanOf(const std::string& quantity, std::size_t first, std::size_t second) {
  for (GrowthPlan& plan : PlanGrowth()) {
    if (plan.series.quantity.find(quantity) != 0) continue;
    plan.cuts = {plan.cuts.at(first), plan.cuts.at(second)};
    return plan;
  }
  ADD_FAILURE() << "no quantity " << quantity;
  return {};
}

GrowthReport Measure(const GrowthPlan& plan) {
  GrowthOptions options;
  options.ticks = 100;
  return MeasureGrowth({plan}, options);
}

using GrowthTest = test::ResultFolderTest;

TEST_F(GrowthTest, WorkOfATickDoesNotDependOnTheSizeOfTheBone) {
  const GrowthReport report = Measure(PlanOf("edges of the bone", 0, 2));
  const GrowthSeries& bone = report.series.front();
  ASSERT_EQ(bone.points.size(), 2u);
  EXPECT_EQ(bone.points[0].value, 1);
  EXPECT_EQ(bone.points[1].value, 2);
  EXPECT_GT(bone.points[0].computed_voxels, 0);
  // The disc is at the same place relative to the top face, but not relative to the voxels, which shifts the borders of
  // bricks and samples.
  EXPECT_NEAR(bone.points[1].computed_voxels / bone.points[0].computed_voxels, 1, 0.1);
  EXPECT_NEAR(bone.points[1].samples / bone.points[0].samples, 1, 0.1);
  // A volume's exponent would be 3; the nodes of the trees above the leaves, which hardly grow, lower it.
  EXPECT_GT(bone.bone.measured, 1);
  EXPECT_LT(bone.bone.measured, 2);
  EXPECT_DOUBLE_EQ(bone.bone.measured, std::log2(bone.points[1].bone_MB / bone.points[0].bone_MB));
  EXPECT_EQ(bone.bone.limit, 2);

  MakeFolder(folder_);
  WriteGrowth(report, folder_);
  const std::string csv = ReadTextFile(folder_ + "/growth.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/growth.png"));
  EXPECT_THAT(FormatGrowthTable(report), testing::HasSubstr("edges of the bone"));
}

TEST_F(GrowthTest, PiecesLeaveTheWorkOfATickAsItIs) {
  const GrowthReport report = Measure(PlanOf("pieces of the bone", 0, 3));
  const std::vector<GrowthPoint>& points = report.series.front().points;
  EXPECT_EQ(points[0].computed_voxels, points[1].computed_voxels);
  EXPECT_EQ(points[0].samples, points[1].samples);
  EXPECT_NE(points[0].hash, points[1].hash);
}

TEST_F(GrowthTest, EachSeriesDiffersInItsQuantity) {
  for (const GrowthPlan& plan : PlanGrowth()) {
    SCOPED_TRACE(plan.series.quantity);
    ASSERT_GE(plan.cuts.size(), 5u);
    std::set<double> values;
    for (const auto& [value, cut] : plan.cuts) values.insert(value);
    EXPECT_EQ(values.size(), plan.cuts.size());
    EXPECT_EQ(plan.series.is_power, *values.begin() > 0);
  }
}

TEST_F(GrowthTest, EffectsAreAddedOneByOneUntilAllAreOn) {
  const std::vector<GrowthPlan> plan = PlanGrowth();
  const auto effects = std::find_if(plan.begin(), plan.end(), [](const GrowthPlan& p) { return !p.series.is_power; });
  ASSERT_NE(effects, plan.end());
  EXPECT_EQ(effects->cuts.size(), Effects().size() + 1);
  for (const auto& [value, cut] : effects->cuts) {
    ASSERT_TRUE(cut.effects.has_value());
    EXPECT_EQ(static_cast<double>(cut.effects->size()), value);
  }
}

}  // namespace
}  // namespace kerf
