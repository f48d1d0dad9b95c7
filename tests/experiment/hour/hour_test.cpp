// Short form of the one-hour test: constant memory, zero force at rest, exact sums. `kerf bench hour` runs the long
// form.
#include "experiment/hour/hour.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "base/files/files.h"
#include "support/result_folder.h"
#include "test_paths.h"

namespace kerf {
namespace {

Scene ReadHourScene() {
  return ReadScene(KERF_SOURCE_DIR "/scenes/one_hour.toml");
}

using HourTest = test::ResultFolderTest;

TEST_F(HourTest, AMinuteOfSawingCausesNoDrift) {
  MakeFolder(folder_);
  HourOptions options;
  options.minutes = 1.25;
  options.each_s = 5;
  options.folder = folder_;
  const Hour hour = RunHour(ReadHourScene(), options, {});
  ASSERT_EQ(hour.minutes.size(), 15U);
  EXPECT_EQ(hour.loop.end, LoopEnd::kRequested);
  EXPECT_EQ(hour.loop.counts.ticks, 75'000U);
  const HourMinute worst = hour.CalcWorst();
  // The session is a realistic one: most ticks cut, and there are pauses.
  EXPECT_GT(worst.cutting_share, 0.7);
  EXPECT_GT(worst.teeth, 1);
  EXPECT_GT(worst.rest_ticks, 2000U);
  EXPECT_GT(worst.removed_mm3, 30);
  // In free air the force is zero, from the first pause to the last.
  EXPECT_EQ(worst.rest_hand_N, 0);
  EXPECT_EQ(worst.rest_device_N, 0);
  // If the rows were kept in memory, they alone would add 15 MB in 70,000 ticks. The heap is checked because resident
  // memory also varies with the system's pages.
  EXPECT_LT(hour.CalcOtherGrowth_MB(), 0.1);
  // The rest grows by the leaves that are cut into, by 2 kB in each place: by far fewer than the 64 x 22 x 6 leaves of
  // the block.
  const HourMinute& second = hour.minutes[1];
  const HourMinute& end = hour.minutes.back();
  EXPECT_LT(end.own_MB - second.own_MB, 1);
  EXPECT_LT(end.simulation_MB - second.simulation_MB, 0.5);
  EXPECT_GT(second.CalcOtherHeap_MB(), 0);
  // These are sums of about 1e5 terms for a bone of 27,200 mm3, each with a rounding error of 1e-16 of that volume.
  EXPECT_LT(std::abs(worst.removed_error_mm3), 1e-16 * 75'000 * hour.volume_before_mm3);
  // The block's edges and corners are chamfered within their voxels, by up to h^2 / 2 along their 576 mm.
  EXPECT_NEAR(hour.volume_before_mm3, 100 * 34 * 8, 576 * 0.5 * 0.2 * 0.2);
  // The volume by occupancy of a kerf two voxels wide is a few percent off, and more at the start of the kerf.
  const HourMinute& last = hour.minutes.back();
  EXPECT_NEAR(last.removed_by_ticks_mm3 / last.removed_mm3, 1, 0.05);
  EXPECT_GT(worst.energy_J, 1e-3);
  // The solver leaves an imbalance of 1e-8 of the forces involved, which may be many times larger than the forces that
  // do work.
  EXPECT_LT(std::abs(worst.energy_error_J), 1e-6 * worst.energy_J);
  EXPECT_TRUE(hour.loop.mirror_identical);
  // Observing the run does not change it.
  LoopOptions plain;
  plain.virtual_time = true;
  plain.seconds = 75;
  plain.output.log = LoopLog::kNone;
  const LoopSummary unwatched = RunLoop(ReadHourScene(), plain, {});
  EXPECT_EQ(unwatched.force_hash, hour.loop.force_hash);
  EXPECT_EQ(unwatched.bone_hash, hour.loop.bone_hash);
}

TEST_F(HourTest, ReportsTheMeasuredFigures) {
  Hour hour;
  hour.scene = "s";
  for (int i = 1; i <= 30; ++i) {
    HourMinute m;
    m.minute = i;
    m.resident_MB = i == 1 ? 300 : 100 + 0.5 * i;
    m.heap_MB = i == 1 ? 300 : 60 + 0.25 * i;
    m.bone_MB = 20 + 0.1 * i;
    m.own_MB = 2 + 0.1 * i;
    m.simulation_MB = 5 + 0.3 * i;
    m.tick_p50_us = i <= 10 ? 20 : i <= 20 ? 99 : 21;
    m.rest_device_N = i == 7 ? 0.25 : 0;
    m.removed_error_mm3 = i == 9 ? -3e-9 : 1e-10;
    hour.minutes.push_back(m);
  }
  // The memory of the first minute (the warm-up) is not counted, nor are the times of the middle ten minutes.
  EXPECT_DOUBLE_EQ(hour.CalcMemoryGrowth_MB(), 14);
  EXPECT_DOUBLE_EQ(hour.CalcOtherGrowth_MB(), 7);
  EXPECT_DOUBLE_EQ(hour.CalcTimeRatio(), 1.05);
  EXPECT_EQ(hour.CalcWorst().removed_error_mm3, -3e-9);
  EXPECT_THAT(FormatHourTable(hour), testing::HasSubstr("0.25 N on the device"));
  EXPECT_THAT(FormatHourMarkdown(hour, "this machine", "h.png"), testing::HasSubstr("| 30 | 115.00 | 23.00 |"));
  std::istringstream csv(FormatCsv(HourColumns(), hour.minutes));
  std::string line;
  std::getline(csv, line);
  const auto columns = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  for (; std::getline(csv, line); ++rows) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
  EXPECT_EQ(rows, 30);
  MakeFolder(folder_);
  WriteHour(hour, folder_);
  EXPECT_TRUE(std::filesystem::exists(folder_ + "/hour.png"));
}

}  // namespace
}  // namespace kerf
