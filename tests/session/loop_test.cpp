// A scene in a simulated hand, without the clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "devices/profiles.h"
#include "files/files.h"
#include "kerf/error.h"
#include "session/hand_motion.h"
#include "session/run_loop.h"

namespace kerf {
namespace {

namespace fs = std::filesystem;

/// A bar of 3 x 4 mm along x, which the disc is lowered through.
constexpr char kScene[] = R"(
[bone]
model = "block"
[bone.block]
size_x_mm = 8.0
size_y_mm = 4.0
size_z_mm = 3.0
voxel_mm = 0.2
[tool]
diameter_mm = 12.0
thickness_mm = 0.5
teeth = 16
[[path.stroke]]
start_mm = [0.0, 0.0, 6.5]
end_mm = [0.0, 0.0, 0.5]
feed_mm_per_s = 3.0
disc_normal = [1.0, 0.0, 0.0]
[[path.stroke]]
start_mm = [2.0, 0.0, 7.0]
end_mm = [2.0, 0.0, 6.5]
feed_mm_per_s = 3.0
disc_normal = [1.0, 0.0, 0.0]
[hand]
model = "H4"
)";

LoopOptions Virtual(double seconds) {
  LoopOptions options;
  options.virtual_time = true;
  options.seconds = seconds;
  return options;
}

LoopSummary RunVirtual(const Scene& scene, double seconds) {
  return RunLoop(scene, Virtual(seconds), {});
}

TEST(RunLoop, CutsThroughAndRemovesTheKerf) {
  const Scene scene = ParseScene(kScene, "s.toml");
  const LoopSummary s = RunVirtual(scene, 6);
  // Height x width x thickness of the disc. It wavers sideways by a part of a voxel: a tenth of the kerf's width.
  EXPECT_NEAR(s.removed_mm3, 3 * 4 * 0.5, 0.6);
  EXPECT_EQ(s.counts.ticks, 6000U);
  EXPECT_EQ(s.counts.missed, 0U);
  EXPECT_EQ(s.counts.not_finite + s.device_counts.not_finite, 0U);
  EXPECT_EQ(s.end, LoopEnd::kAsked);
  EXPECT_TRUE(s.mirror_identical);
  EXPECT_GT(s.leaves_sent, 0U);
  EXPECT_GE(s.strokes, 2);
  EXPECT_LE(s.force.largest_step_N, s.force.slew_bound_N);
  EXPECT_GT(s.force.largest_N, 0.01);
  // What the hand and the spindle put in went into the cut and into friction, or is in the springs.
  EXPECT_GT(s.cut_J, 0);
  EXPECT_GE(s.hand_J + s.spindle_J, s.cut_J + s.friction_J - 1e-6);
}

TEST(RunLoop, GivesTheSameBitsTwice) {
  const Scene scene = ParseScene(kScene, "s.toml");
  const LoopSummary a = RunVirtual(scene, 1);
  const LoopSummary b = RunVirtual(scene, 1);
  EXPECT_EQ(a.bone_hash, b.bone_hash);
  EXPECT_EQ(a.force_hash, b.force_hash);
  EXPECT_NE(a.force_hash, 0U);
  Scene other = scene;
  other.hand.model = "H3";
  EXPECT_NE(RunVirtual(other, 1).force_hash, a.force_hash);
}

TEST(RunLoop, EachRateRunsAsLong) {
  Scene scene = ParseScene(kScene, "s.toml");
  for (const double rate_hz : {250.0, 4000.0}) {
    scene.loop.rate_hz = rate_hz;
    const LoopSummary s = RunVirtual(scene, 0.5);
    EXPECT_EQ(s.counts.ticks, static_cast<std::uint64_t>(std::lround(0.5 * rate_hz)));
    EXPECT_NEAR(s.simulated_s, 0.5, 1e-9);
  }
}

TEST(RunLoop, LiveItDoesTheSameWork) {
  Scene scene = ParseScene(kScene, "s.toml");
  LoopOptions options;
  options.seconds = 0.3;
  const LoopSummary s = RunLoop(scene, options, {});
  EXPECT_EQ(s.end, LoopEnd::kAsked);
  EXPECT_GT(s.counts.ticks, 0U);
  EXPECT_TRUE(s.mirror_identical);
  EXPECT_FALSE(s.grants.scheduling.empty());
  EXPECT_FALSE(s.grants.memory.empty());
  EXPECT_EQ(s.tick.count, s.counts.ticks);
}

TEST(RunLoop, StopsWhenItIsToldTo) {
  const std::atomic<bool> stop{true};
  LoopOptions options;
  options.seconds = 1000;
  options.stop = &stop;
  EXPECT_EQ(RunLoop(ParseScene(kScene, "s.toml"), options, {}).end, LoopEnd::kAsked);
  options.virtual_time = true;
  EXPECT_LT(RunLoop(ParseScene(kScene, "s.toml"), options, {}).counts.ticks, 10U);
}

TEST(RunLoop, DegradesAndComesBackWhileTimeIsBurnt) {
  Scene scene = ParseScene(kScene, "s.toml");
  scene.loop.degrade = true;
  LoopOptions options = Virtual(9);
  options.burn_us = 1500;
  const LoopSummary s = RunLoop(scene, options, {});
  ASSERT_GE(s.fidelity_steps.size(), 2U);
  EXPECT_EQ(s.fidelity_steps[0].from, Fidelity::kFull);
  EXPECT_EQ(s.fidelity_steps[0].to, Fidelity::kCoarse);
  EXPECT_EQ(s.fidelity_steps.back().to, Fidelity::kFull);
  EXPECT_GT(s.counts.missed, 0U);
  EXPECT_LE(s.force.largest_step_N, s.force.slew_bound_N);
}

std::string MessageOf(const Scene& scene, double seconds = 1) {
  try {
    RunVirtual(scene, seconds);
    return "";
  } catch (const Error& e) {
    return e.what();
  }
}

TEST(RunLoop, SaysWhatItCanNotDo) {
  Scene slab = ParseScene(kScene, "s.toml");
  slab.simulation.mode = SceneMode::kSlab;
  EXPECT_EQ(MessageOf(slab),
            "[simulation] mode = \"slab\" has no tool in a hand; set mode = \"voxel\" for 'kerf loop'");
  EXPECT_EQ(MessageOf(ParseScene(kScene, "s.toml"), 0), "the loop can't run for 0 s; give 0.01 to 3600");
}

TEST(LoopReport, FilesAgreeWithTheSummary) {
  const std::string folder = (fs::temp_directory_path() / ("kerf_loop_" + std::to_string(getpid()))).string();
  Scene scene = ParseScene(kScene, "s.toml");
  scene.output.forces_every_ticks = 3;
  const LoopSummary s = RunVirtual(scene, 1);
  for (const std::string& name : WriteLoopReport(scene, s, folder)) {
    EXPECT_GT(fs::file_size(fs::path(folder) / name), 100U) << name;
  }
  const auto json = nlohmann::json::parse(ReadTextFile(folder + "/loop.json"));
  EXPECT_EQ(json["ticks"]["count"], 1000);
  EXPECT_EQ(json["removed_mm3"], s.removed_mm3);
  EXPECT_TRUE(json["published"]["copy_is_bit_identical"]);
  EXPECT_EQ(json["lateness"]["count"], 1000);
  std::uint64_t in_bars = 0;
  for (const auto& bar : json["tick_bars_us"]) in_bars += bar[2].get<std::uint64_t>();
  EXPECT_EQ(in_bars, 1000U);
  std::istringstream csv(ReadTextFile(folder + "/forces.csv"));
  std::string line;
  std::getline(csv, line);
  const auto commas = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  double removed_mm3 = 0;
  while (std::getline(csv, line)) {
    ++rows;
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas);
    std::istringstream cells(line);
    std::string cell;
    for (int i = 0; i < 20; ++i) std::getline(cells, cell, ',');
    removed_mm3 += std::stod(cell);
  }
  EXPECT_EQ(rows, 333);
  // By occupancy: to some percent of the exact volume.
  EXPECT_NEAR(removed_mm3, s.removed_mm3, 0.1 * s.removed_mm3);
  fs::remove_all(folder);
}

TEST(HandMotion, WaitsWhenTheHandleIsHeldAndGoesRoundWhenItIsFree) {
  const Scene scene = ParseScene(kScene, "s.toml");
  const Path path = MakePath(scene);
  SceneHand params;
  params.lead_mm = 3;
  {
    DeviceProfile free = FindDeviceProfile("ideal");
    SimulatedDevice device(free, FindHandModel("H4"), path.CalcPose(0, 0));
    HandMotion hand(device, path, params, Vec3{0});
    double lowest = 1e9;
    for (int tick = 0; tick < 16'000; ++tick) {
      hand.Advance(0.001);
      device.Elapse(0.001);
      lowest = std::min(lowest, device.p_WC_mm().z);
    }
    EXPECT_NEAR(lowest, 0.5, 0.5);  // the stroke's end, but for the lag of its last moment
    EXPECT_GE(hand.rounds(), 2);
  }
  {
    // So heavy that it doesn't move.
    DeviceProfile held = FindDeviceProfile("ideal");
    held.mass_kg = 1e9;
    SimulatedDevice device(held, FindHandModel("H4"), path.CalcPose(0, 0));
    HandMotion hand(device, path, params, Vec3{0});
    for (int tick = 0; tick < 20'000; ++tick) {
      hand.Advance(0.001);
      device.Elapse(0.001);
    }
    EXPECT_EQ(hand.strokes(), 1);
    EXPECT_EQ(hand.rounds(), 0);
  }
}

}  // namespace
}  // namespace kerf
