#include "experiment/draw_bench/view_bench.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "kerf/error.h"

namespace kerf {
namespace {

using ::testing::HasSubstr;

// Checks that each time was measured and that the cut is the same each time. The values of the times are not checked.
TEST(ViewBench, MeasuresEachFigureOnASmallBone) {
  ViewBenchOptions options;
  options.voxel_mm = 0.5;
  options.width = 640;
  options.height = 360;
  options.frames = 5;
  options.cut_mm = 4;
  const ViewReport report = RunViewBench(options);
  EXPECT_FALSE(report.renderer.empty());
  EXPECT_GT(report.bone_ms, 0);
  EXPECT_GT(report.meshing_ms, 0);
  EXPECT_GT(report.first_frame_ms, 0);
  EXPECT_GT(report.cut_leaves, 0u);
  EXPECT_GT(report.both.count, 0u);
  EXPECT_GE(report.both.max_us, report.remesh.p50_us);
  ASSERT_EQ(report.frames.size(), 4u);
  for (const ViewFrames& frames : report.frames) {
    EXPECT_EQ(frames.times.count, 5u);
    EXPECT_GT(frames.triangles, 100u) << frames.view;
    EXPECT_LE(frames.p95_us, frames.times.max_us);
  }
  EXPECT_GT(report.surface_MB, 0.1);
  EXPECT_EQ(RunViewBench(options).bone_hash, report.bone_hash);

  const auto json = nlohmann::json::parse(FormatViewJson(report));
  EXPECT_EQ(json["frames"].size(), 4u);
  EXPECT_THAT(FormatViewMarkdown(report), HasSubstr("| frame, whole bone |"));
  EXPECT_THAT(FormatViewTable(report), HasSubstr(report.renderer));
}

TEST(ViewBench, RefusesOptionsOutOfRange) {
  ViewBenchOptions options;
  options.frames = 1;
  EXPECT_THROW(RunViewBench(options), Error);
  options = {};
  options.voxel_mm = 0.05;
  EXPECT_THROW(RunViewBench(options), Error);
}

}  // namespace
}  // namespace kerf
